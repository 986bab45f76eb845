#include "app/commands/length_unit.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <vector>

namespace limberg {

namespace {

struct Unit {
  const char* name;
  double mm;
};
constexpr Unit kUnits[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"inch", 25.4}};

}  // namespace

double mm_of(const std::string& unit) {
  return std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& u) { return unit == u.name; })->mm;
}

void add_unit(CLI::App& command, std::string& unit, const std::string& what) {
  std::vector<std::string> names;
  for (const Unit& u : kUnits) names.push_back(u.name);
  command.add_option("--unit", unit, what + " [mm]")->check(CLI::IsMember(names));
}

std::string likely_units(double length, double least_mm, double most_mm) {
  const auto likely = [&](double mm) { return mm >= least_mm && mm <= most_mm; };
  if (likely(length)) return "";
  std::string out;
  for (const Unit& u : kUnits)
    if (likely(length * u.mm))
      out += fmt::format("{}--unit {} ({:.0f} mm)", out.empty() ? "" : " or ", u.name, length * u.mm);
  return out;
}

}  // namespace limberg
