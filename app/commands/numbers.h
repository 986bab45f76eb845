#pragma once
// What a number on the command line may be. CLI11's own ranges let nan through (no comparison with it is true), take -1
// for a large unsigned number and print the limits of a double with 309 digits.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <string>

namespace limberg {

namespace number_words {

inline std::string words(const char* kind, const char* between, double least, double most) {
  return fmt::format("{} {:.15g}{}{:.15g}", kind, least, between, most);
}

inline std::string refusal(const std::string& value, const char* kind, double least, double most) {
  return "\"" + value + "\" cannot be used; expected " + words(kind, " to ", least, most);
}

}  // namespace number_words

/// A finite number from `least` to `most`, both included.
inline CLI::Validator number_from(double least, double most) {
  return CLI::Validator(
      [least, most](std::string& value) -> std::string {
        char* end = nullptr;
        const double x = std::strtod(value.c_str(), &end);
        if (!value.empty() && *end == '\0' && std::isfinite(x) && x >= least && x <= most) return {};
        return number_words::refusal(value, "a number from", least, most);
      },
      number_words::words("NUMBER in [", " - ", least, most) + "]");
}

/// A whole number from `least` to `most`, both included, within the 53 bits that a double holds.
inline CLI::Validator whole_from(int64_t least, int64_t most) {
  return CLI::Validator(
      [least, most](std::string& value) -> std::string {
        char* end = nullptr;
        errno = 0;
        const long long x = std::strtoll(value.c_str(), &end, 10);
        if (!value.empty() && *end == '\0' && errno == 0 && x >= least && x <= most) return {};
        return number_words::refusal(value, "a whole number from", double(least), double(most));
      },
      number_words::words("INT in [", " - ", double(least), double(most)) + "]");
}

/// Any finite number of everyday size.
inline CLI::Validator any_number() { return number_from(-1e9, 1e9); }

}  // namespace limberg
