// Every number of the result, under its name there.
#include "app/report/html.h"
#include "app/report/sections.h"

namespace limberg::sections {

html::Markup figures(const ReportSource& source) {
  const ReportData& d = source.d;
  std::vector<html::Row> rows;
  const auto row = [&](const std::string& name, double v) { rows.push_back({html::code(name), html::number(v, 6)}); };
  for (const auto& [name, v] : d.metrics) {
    row(name, v);
    const auto e = d.errors.find(name);
    if (!d.errors.empty()) rows.back().push_back(e == d.errors.end() ? "" : html::quantity(e->second.error, "", 2));
  }
  for (const auto& [name, v] : d.lattice_numbers) row("lattice." + name, v);
  if (d.solve_ms) row("solve_ms", *d.solve_ms);
  if (rows.empty()) return {};
  const Words& w = d.w;
  std::string about = w("Units stand in the names; a name without a unit is a ratio or a count.");
  if (!d.errors.empty())
    about += std::string(" ") + w("Third column: the lattice's share of the error, where it is known.");
  return html::section(w("All figures"), html::note(about) + html::table({}, rows));
}

}  // namespace limberg::sections
