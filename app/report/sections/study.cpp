// What a study came to: its charts, its bars and its table.
#include "app/report/html.h"
#include "app/report/sections.h"

namespace limberg::sections {

html::Markup study(const ReportSource& source) {
  const ReportData& d = source.d;
  if (d.study_columns.empty() || d.study_rows.empty()) return {};
  html::Markup body;
  if (!d.about.empty()) body += html::paragraph(d.w.said(d.about));
  for (const ResultChart& c : d.charts) body += chart_of(c, d.w);
  body += bars_of(d);
  std::vector<html::Row> rows;
  constexpr size_t kMostRows = 200;  // a page of thousands opens slowly, and nobody reads them there
  for (const auto& row : d.study_rows) {
    if (rows.size() == kMostRows) break;
    html::Row cells;
    for (const Maybe& v : row) cells.push_back(html::quantity(v, "", 4));
    rows.push_back(cells);
  }
  body += html::table(html::Row(d.study_columns.begin(), d.study_columns.end()), rows);
  if (rows.size() < d.study_rows.size())
    body += html::note(
        d.w("These are {} of {} members; rows.csv and result.json have all.", rows.size(), d.study_rows.size()));
  return html::section(d.w("What it came to"), body);
}

}  // namespace limberg::sections
