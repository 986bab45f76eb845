// Volume and forces, which must add up.
#include <algorithm>
#include <cmath>

#include "app/report/html.h"
#include "app/report/sections.h"

namespace limberg::sections {

using html::number;
using html::quantity;

namespace {

std::vector<html::Row> volume_rows(const ReportData& d) {
  const Words& w = d.w;
  std::vector<html::Row> rows;
  const Maybe left = d.metric("volume_mm3"), out = d.metric("removed_volume_mm3"),
              before = d.metric("initial_volume_mm3");
  if (before) rows.push_back({w("volume before the operation"), quantity(before, "mm³", 10)});
  if (left) rows.push_back({w("volume of what remains, at rest"), quantity(left, "mm³", 10)});
  if (out) rows.push_back({w("volume of what was taken away"), quantity(out, "mm³", 10)});
  if (!d.metric("volume_change") && before && left && out && *before > 0)
    rows.push_back({w("remainder + removed − before, relative"), number((*left + *out - *before) / *before, 2)});
  if (const Maybe v = d.metric("volume_change"))
    rows.push_back({w("volume that cutting lost or made, relative"), number(*v, 2)});
  if (const Maybe v = d.metric("compression"))
    rows.push_back({w("change of volume under load, relative"), number(*v, 2)});
  if (const Maybe v = d.metric("pieces")) rows.push_back({w("pieces"), number(*v)});
  if (const Maybe v = d.metric("min_J")) rows.push_back({w("smallest volume ratio J of a cell"), number(*v, 3)});
  if (const Maybe v = d.metric("inverted_cells")) rows.push_back({w("inverted cells"), number(*v)});
  return rows;
}

/// "sum" of "sum_N".
std::string name_of_force(std::string name) {
  if (name.size() > 2 && name.ends_with("_N")) name.resize(name.size() - 2);
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

}  // namespace

html::Markup balance(const ReportSource& source) {
  const ReportData& d = source.d;
  const Words& w = d.w;
  html::Markup body;
  if (const std::vector<html::Row> rows = volume_rows(d); !rows.empty())
    body += html::titled(w("Volume"), html::table({}, rows));
  if (!d.balance.empty()) {
    std::vector<html::Row> rows;
    for (const auto& [name, f] : d.balance) {
      html::Row row{w.said(name_of_force(name))};
      for (const double v : f) row.push_back(quantity(v, "N"));
      row.push_back(quantity(std::hypot(f[0], f[1], f[2]), "N"));
      rows.push_back(row);
    }
    body += html::titled(w("Forces on the tissue"), html::table({"", "x", "y", "z", w("size")}, rows));
    if (d.balance_relative)
      body += html::paragraph(w("What is left over is {} % of the sum of the magnitudes (goal: below 1 %).",
                                number(100 * *d.balance_relative, 2)));
  }
  return html::section(w("Does it add up?"), body);
}

}  // namespace limberg::sections
