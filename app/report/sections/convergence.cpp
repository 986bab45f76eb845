// The same operation on lattices of several sizes, and what the lattice does to each figure.
#include <algorithm>

#include "app/report/html.h"
#include "app/report/sections.h"

namespace limberg::sections {

using html::number;
using html::quantity;

namespace {

struct ConvergenceColumn {
  const char *name, *unit;
  Maybe (*value)(const ResultConvergence&);
  bool difference;  // against the row above
};
const ConvergenceColumn kConvergence[] = {
    {english("Cell"), "mm", [](const ResultConvergence& r) { return r.cell_mm; }, false},
    {english("Lattice nodes"), "",
     [](const ResultConvergence& r) { return r.nodes ? Maybe(double(*r.nodes)) : Maybe(); }, false},
    {english("Closure force"), "N", [](const ResultConvergence& r) { return r.closure_force_N; }, true},
    {english("Largest suture force"), "N", [](const ResultConvergence& r) { return r.suture_force_max_N; }, true},
    {english("Largest gap"), "mm", [](const ResultConvergence& r) { return r.suture_gap_max_mm; }, true},
    {english("Dog-ear"), "mm", [](const ResultConvergence& r) { return r.dog_ear_mm; }, true},
    {english("Residual"), "", [](const ResultConvergence& r) { return r.residual; }, false},
    {english("Solve"), "ms", [](const ResultConvergence& r) { return r.solve_ms; }, false}};

html::Markup cell_of(const ConvergenceColumn& c, const ResultConvergence& row, const ResultConvergence* above) {
  const Maybe v = c.value(row);
  html::Markup words = c.unit[0] == 0 && v && *v >= 1 ? number(*v, 7) : quantity(v, c.unit);
  if (c.difference && v && above && c.value(*above)) {
    const double change = *v - *c.value(*above);
    words += " " + html::soft("(" + std::string(change > 0 ? "+" : "") + number(change, 2) + ")");
  }
  return words;
}

html::Markup lattice_errors(const ReportData& d) {
  if (d.errors.empty()) return {};
  const Words& w = d.w;
  std::vector<html::Row> rows;
  for (const auto& [name, e] : d.errors)
    rows.push_back({html::code(name), quantity(e.value, ""), quantity(e.error, "", 2), quantity(e.extrapolated, ""),
                    quantity(e.order, "", 2), html::soft_cell(w.said(e.says))});
  return html::paragraph(
             w("What the lattice does to each figure: the finest value, its estimated error (Eça and Hoekstra, 2014), "
               "and what it tends to as the cells shrink. Where the sizes are not in the asymptotic range nothing is "
               "extrapolated, and the error is taken three times as large.")) +
         html::table({w("Figure"), w("finest"), "±", w("limit"), w("order"), ""}, rows);
}

}  // namespace

html::Markup convergence(const ReportSource& source) {
  const std::vector<ResultConvergence>& runs = source.d.convergence;
  if (runs.empty()) return {};
  const Words& w = source.d.w;
  html::Row head;
  std::vector<html::Row> rows(runs.size());
  for (const ConvergenceColumn& c : kConvergence) {
    if (std::none_of(runs.begin(), runs.end(), [&](const ResultConvergence& r) { return bool(c.value(r)); })) continue;
    head.push_back(w(c.name));
    for (size_t i = 0; i < runs.size(); ++i) rows[i].push_back(cell_of(c, runs[i], i > 0 ? &runs[i - 1] : nullptr));
  }
  return html::section(
      w("Finer cells, same answer?"),
      html::paragraph(w("The same script at several lattice sizes. In brackets: change against the row "
                        "above; it should shrink.")) +
          html::table(head, rows) + lattice_errors(source.d));
}

}  // namespace limberg::sections
