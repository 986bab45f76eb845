// What a study came to: its charts, its bars and its table.
#include <algorithm>
#include <cmath>

#include "app/report/html.h"
#include "app/report/sections.h"
#include "app/report/svg_chart.h"

namespace limberg::sections {

using html::escape;
using html::number;

std::string chart_figure(const ResultChart& c) {
  LineChart chart;
  chart.description = c.description;
  chart.x.title = c.x, chart.y.title = c.y;
  chart.x.log = c.x_log, chart.y.log = c.y_log;
  for (const auto& s : c.series) chart.series.push_back({s.name, s.x, s.y, s.markers});
  for (const ResultMark& m : c.x_marks) chart.x_marks.push_back({m.value, m.label});
  for (const ResultMark& m : c.y_marks) chart.y_marks.push_back({m.value, m.label});
  return "<h3>" + escape(c.title) + "</h3>\n<figure class=\"wide\">" + svg(chart) + "</figure>\n";
}

std::string bars(const ReportData& d) {
  if (d.bars.empty()) return {};
  std::string out =
      "<div class=\"wide\"><table class=\"bars\">\n<thead><tr><th>What is "
      "asked</th><th>Value</th><th>Bar</th><th></th><th>Where it comes from</th></tr></thead>\n<tbody>\n";
  for (const ResultBar& b : d.bars)
    out += "<tr><td>" + escape(b.name) + "</td><td>" + (b.value ? number(*b.value) : "–") + "</td><td>" +
           (b.larger_is_better ? "≥ " : "≤ ") + (b.bar ? number(*b.bar) : "–") + "</td><td><b class=\"" +
           (b.pass ? "good" : "bad") + "\">" + (b.pass ? "met" : "missed") + "</b></td><td>" + escape(b.source) +
           "</td></tr>\n";
  return out + "</tbody></table></div>\n";
}

std::string study(const ReportData& d) {
  if (d.study_columns.empty() || d.study_rows.empty()) return {};
  std::string out = "<section>\n<h2>What it came to</h2>\n";
  if (!d.about.empty()) out += "<p>" + escape(d.about) + "</p>\n";
  for (const ResultChart& c : d.charts) out += chart_figure(c);
  out += bars(d);
  out += "<div class=\"wide\"><table>\n<thead><tr>";
  for (const std::string& c : d.study_columns) out += "<th>" + escape(c) + "</th>";
  out += "</tr></thead>\n<tbody>\n";
  for (const auto& row : d.study_rows) {
    out += "<tr>";
    for (const Maybe& v : row) out += "<td>" + (v ? number(*v, 4) : "–") + "</td>";
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n</section>\n";
}

}  // namespace limberg::sections
