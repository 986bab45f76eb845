// How close to equilibrium the tissue was, step by step.
#include <algorithm>

#include "app/report/sections.h"

namespace limberg::sections {

html::Markup residual(const ReportSource& source) {
  const ReportData& d = source.d;
  const Words& w = d.w;
  const size_t n = std::max(d.series_residual.size(), d.series_distance_mm.size());
  if (n < 2) return {};
  std::vector<double> t = d.series_t_s;
  const bool timed = t.size() >= n;
  if (!timed) {
    t.resize(n);
    for (size_t i = 0; i < n; ++i) t[i] = double(i);
  }
  LineChart chart;
  chart.x.title = w(timed ? english("time of the recording, s") : english("solver step"));
  chart.y.log = true;
  html::Markup body = html::paragraph(
      w("The relative residual is the size of the unbalanced forces over that of all internal forces. Each action "
        "throws it up; the solver brings it down."));
  if (d.series_residual.size() > 1) {
    chart.description = w("Relative residual over time");
    chart.y.title = w("relative residual");
    chart.series = {{w("residual"), t, d.series_residual, false}};
    chart.y_marks = {{kAtRest, w("goal")}};
    if (timed) chart.x_marks = stage_marks(d);
    body += html::chart(svg(chart));
  }
  if (d.series_distance_mm.size() > 1) {
    chart.description = w("Estimated distance to equilibrium over time");
    chart.y.title = w("estimated distance, mm");
    chart.series = {{w("distance"), t, d.series_distance_mm, false}};
    chart.y_marks.clear();
    chart.height = 240;
    body += html::paragraph(
                w("The largest distance of any node from where it will come to rest, as every frame estimates it while "
                  "it works.")) +
            html::chart(svg(chart));
  }
  return html::section(w("How close to equilibrium"), body);
}

}  // namespace limberg::sections
