#pragma once
// What the numbers of a file of points or triangles are: such files do not say.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

namespace limberg {

inline double mm_of(const std::string& unit) {
  return unit == "cm" ? 10 : unit == "m" ? 1000 : unit == "inch" ? 25.4 : 1;
}

inline CLI::Option* add_unit(CLI::App& command, std::string& unit, const std::string& what) {
  return command.add_option("--unit", unit, what + " [mm]")->check(CLI::IsMember({"mm", "cm", "m", "inch"}));
}

/// Of a length in numbers of a file: the units in which it would be from `least_mm` to `most_mm` long, as words of a
/// sentence: "--unit cm (120 mm) or --unit inch (305 mm)". Empty: none of them, or mm.
inline std::string likely_units(double length, double least_mm, double most_mm) {
  if (length >= least_mm && length <= most_mm) return "";
  std::string out;
  for (const char* unit : {"cm", "m", "inch"})
    if (const double mm = length * mm_of(unit); mm >= least_mm && mm <= most_mm)
      out += fmt::format("{}--unit {} ({:.0f} mm)", out.empty() ? "" : " or ", unit, mm);
  return out;
}

}  // namespace limberg
