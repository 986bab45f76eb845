#include "app/result/tables.h"

#include <fmt/format.h>

#include <cmath>

namespace limberg {

void add_table(Result& r, const ResultTable& t) { append(r, "/tables", t); }

void add_chart(Result& r, const std::string& title, const LineChart& c) {
  ResultChart out{title, c.description, c.x.title, c.y.title, c.x.log, c.y.log, {}, {}, {}};
  for (const ChartSeries& s : c.series) out.series.push_back({s.name, s.x, s.y, s.markers});
  for (const ChartMark& m : c.x_marks) out.x_marks.push_back({m.value, m.label});
  for (const ChartMark& m : c.y_marks) out.y_marks.push_back({m.value, m.label});
  append(r, "/charts", out);
}

std::string short_number(double v, int digits) {
  if (!std::isfinite(v)) return "-";
  return fmt::format("{:.{}g}", v, digits);
}

}  // namespace limberg
