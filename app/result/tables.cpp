#include "app/result/tables.h"

#include <fmt/format.h>

#include <cmath>

namespace limberg {

void add_table(Result& r, int number, const ResultTable& t) {
  const std::string p = "/tables/" + std::to_string(number);
  r.set(p + "/title", t.title);
  r.set(p + "/about", t.about);
  for (size_t i = 0; i < t.columns.size(); ++i) r.set(p + "/columns/" + std::to_string(i), t.columns[i]);
  r.set_empty_list(p + "/rows");
  for (size_t i = 0; i < t.rows.size(); ++i)
    for (size_t k = 0; k < t.rows[i].size(); ++k)
      r.set(p + "/rows/" + std::to_string(i) + "/" + std::to_string(k), t.rows[i][k]);
}

void add_chart(Result& r, int number, const std::string& title, const LineChart& c) {
  const std::string p = "/charts/" + std::to_string(number);
  r.set(p + "/title", title);
  r.set(p + "/description", c.description);
  r.set(p + "/x", c.x.title);
  r.set(p + "/y", c.y.title);
  if (c.x.log) r.set(p + "/x_log", true);
  if (c.y.log) r.set(p + "/y_log", true);
  for (size_t k = 0; k < c.series.size(); ++k) {
    const ChartSeries& s = c.series[k];
    const std::string q = p + "/series/" + std::to_string(k);
    const std::vector<float> x(s.x.begin(), s.x.end()), y(s.y.begin(), s.y.end());
    r.set(q + "/name", s.name);
    r.set(q + "/markers", s.markers);
    r.set(q + "/x", std::span<const float>(x));
    r.set(q + "/y", std::span<const float>(y));
  }
  for (const auto& [key, marks] : {std::pair("/x_marks/", &c.x_marks), std::pair("/y_marks/", &c.y_marks)})
    for (size_t k = 0; k < marks->size(); ++k) {
      const std::string q = p + key + std::to_string(k);
      r.set(q + "/value", (*marks)[k].value);
      r.set(q + "/label", (*marks)[k].label);
    }
}

std::string short_number(double v, int digits) {
  if (!std::isfinite(v)) return "-";
  return fmt::format("{:.{}g}", v, digits);
}

}  // namespace limberg
