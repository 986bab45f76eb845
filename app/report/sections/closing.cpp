// What the operation, or another command, came to: forces over time, charts and tables that the command left, what the
// plan foretold, landmarks, perfusion.
#include <algorithm>
#include <filesystem>

#include "app/report/html.h"
#include "app/report/report_names.h"
#include "app/report/sections.h"
#include "app/result/settled_forces.h"
#include "sim/base/whole_file.h"

namespace limberg::sections {

using html::quantity;

namespace {

/// A map that the run has left beside its result.
html::Markup map_in(const std::string& dir, const char* name, const char* alt) {
  try {
    const std::string svg = read_whole_file((std::filesystem::path(dir) / name).string(), size_t(4) << 20);
    return svg.starts_with("<svg") ? html::map(html::svg_data_url(svg), alt) : html::Markup{};
  } catch (const InputError&) {
    return {};  // none, or none to be shown
  }
}

/// What is no force is not drawn, and said.
html::Markup left_out(const SettledForces& f, const Words& w) {
  if (f.unsettled == 0) return {};
  double most = 0;
  for (const double v : f.sum_N)
    if (v > most) most = v;
  return html::note(
      w("{} of {} samples with stitches are left out, gaps in the lines: there the tissue was out of balance by more "
        "than 1 % of its forces (the solver had not caught up with the hand), and what a thread then says is no force. "
        "The largest sum in the others is {}.",
        html::number(double(f.unsettled)), html::number(double(f.pulling)), quantity(most, "N")));
}

html::Markup force_over_time(const ReportData& d) {
  if (d.series_closure_N.size() < 2 || d.series_t_s.size() < d.series_closure_N.size()) return {};
  const SettledForces settled = settled_forces(d.series_residual, d.series_closure_N, d.series_suture_max_N);
  if (settled.pulling == 0) return {};
  const std::vector<double>& sum = settled.sum_N;
  const Words& w = d.w;
  LineChart chart;
  chart.description = w("Sum of the stitches' forces and the largest of them over time");
  chart.x.title = w("time of the recording, s"), chart.y.title = "N";
  std::vector<double> t = d.series_t_s;
  t.resize(sum.size());
  chart.series.push_back(thinned({w("sum of all stitches"), t, sum, false}, 600));
  if (settled.most_N.size() == t.size())
    chart.series.push_back(thinned({w("largest stitch"), t, settled.most_N, false}, 600));
  chart.x_marks = stage_marks(d);
  return html::titled(w("Closure force over the operation"), left_out(settled, w) + html::chart(svg(chart)));
}

html::Markup table_of(const ResultTable& t, const Words& w) {
  std::vector<html::Row> rows;
  for (const auto& r : t.rows) {
    html::Row& row = rows.emplace_back();
    for (const std::string& cell : r) row.push_back(w.said(cell));
  }
  html::Row head;
  for (const std::string& column : t.columns) head.push_back(w.said(column));
  return html::titled(w.said(t.title),
                      (t.about.empty() ? html::Markup() : html::paragraph(w.said(t.about))) + html::table(head, rows));
}

html::Markup foretold(const ReportData& d) {
  std::vector<html::Row> rows;
  for (const ResultPoint& p : entries(d.patient.predicted))
    rows.push_back({"(" + quantity(p.x_mm, "") + ", " + quantity(p.y_mm, "") + ")", quantity(p.charge_deg, "°"),
                    quantity(p.deficit_deg, "°"), quantity(p.height_mm, "mm"), quantity(p.volume_mm3, "mm³")});
  if (rows.empty()) return {};
  const Words& w = d.w;
  return html::titled(
      w("What the plan foretold"),
      html::paragraph(
          w("At each point where tissue angles of sum S are sewn together, 360° − S is foretold: above nothing a cone "
            "that stands up, below it a saddle and tension. Beside it the deficit that is there now, stretch included, "
            "and what stands up.")) +
          html::table({w("Place on the chart, mm"), w("foretold"), w("deficit now"), w("height"), w("volume")}, rows));
}

html::Markup landmarks(const ReportData& d) {
  std::vector<html::Row> rows;
  for (const ResultLandmark& l : entries(d.patient.landmarks))
    rows.push_back({l.name, quantity(l.displacement_mm, "mm", 2), quantity(l.along_mm, "mm", 2),
                    quantity(l.across_mm, "mm", 2), quantity(l.up_mm, "mm", 2)});
  if (rows.empty()) return {};
  const Words& w = d.w;
  return html::titled(w("Landmarks"), html::table({w("Landmark"), w("displaced by"), w("along the tension lines"),
                                                   w("across"), w.as("direction", "up")},
                                                  rows));
}

html::Markup perfusion(const ReportData& d) {
  const Maybe undermined = d.metric("undermined_mm2");
  if (!undermined || *undermined <= 0) return {};
  const auto area = [&](const char* name) { return quantity(d.metric(name), "mm²"); };
  const Words& w = d.w;
  std::string words =
      w("{} of skin are undermined; {} of it lie more than 20 mm of skin away from skin that is still attached, where "
        "perfusion of random flaps in pigs was 40 % and less (Memarzadeh 2016: 40, 20 and about 0 % at 20, 25 and 30 "
        "mm). Lowest index {}, farthest {}.",
        quantity(undermined, "mm²"), area("perfusion_below_40_mm2"), quantity(d.metric("perfusion_least"), "", 2),
        quantity(d.metric("perfusion_farthest_mm"), "mm"));
  if (d.metric("perfusion_severed_mm2").value_or(0) > 0.5)
    words += " " + w("Without any pedicle are {}.", area("perfusion_severed_mm2"));
  words += std::string(" ") +
           w("It orders places and designs; it foretells no necrosis: the source gives no spread, and facial skin is "
             "perfused better than a pig's flank.");
  return html::titled(w("Perfusion risk"), html::paragraph(words));
}

}  // namespace

html::Markup closing(const ReportSource& source) {
  const ReportData& d = source.d;
  const Words& w = d.w;
  html::Markup body = force_over_time(d);
  if (d.command != "study")
    for (const ResultChart& c : d.charts) body += chart_of(c, w);
  if (d.command == "bench") body += bars_of(d);
  for (const ResultTable& t : d.tables) body += table_of(t, w);
  body += foretold(d) + landmarks(d) + perfusion(d);
  body += map_in(source.dir, report_names::ranking,
                 w("The best designs as they would lie on the skin, and what each costs"));
  body += map_in(source.dir, report_names::perfusion, w("Map of the perfusion index on the chart"));
  body += map_in(source.dir, report_names::stress, w("Map of the skin's largest principal stress on the chart"));
  const bool of_a_measurement = d.command == "superpose" || d.command == "bench" || d.command == "fit";
  return html::section(w(of_a_measurement ? english("What it came to")
                         : d.of_bones()   ? english("Bones and face")
                                          : english("The closure")),
                       body);
}

}  // namespace limberg::sections
