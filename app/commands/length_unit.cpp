#include "app/commands/length_unit.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

namespace limberg {

double mm_of(const std::string& unit) { return unit == "cm" ? 10 : unit == "m" ? 1000 : unit == "inch" ? 25.4 : 1; }

void add_unit(CLI::App& command, std::string& unit, const std::string& what) {
  command.add_option("--unit", unit, what + " [mm]")->check(CLI::IsMember({"mm", "cm", "m", "inch"}));
}

std::string likely_units(double length, double least_mm, double most_mm) {
  if (length >= least_mm && length <= most_mm) return "";
  std::string out;
  for (const char* unit : {"cm", "m", "inch"})
    if (const double mm = length * mm_of(unit); mm >= least_mm && mm <= most_mm)
      out += fmt::format("{}--unit {} ({:.0f} mm)", out.empty() ? "" : " or ", unit, mm);
  return out;
}

}  // namespace limberg
