#pragma once
// A text as TOML has it, in quotes.
#include <fmt/format.h>

#include <string>
#include <string_view>

namespace limberg {

inline bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

inline std::string quoted_toml(std::string_view text) {
  std::string s = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      s += '\\', s += c;
    else if (is_control(c))
      s += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    else
      s += c;
  }
  return s + "\"";
}

}  // namespace limberg
