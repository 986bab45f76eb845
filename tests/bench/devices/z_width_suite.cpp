#include "tests/bench/devices/z_width_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/bench/devices/z_width.h"

namespace limberg::bench {

namespace {

constexpr double kOwn = 0.001;  // N s/mm, the damping of the device

Row row_of(const std::string& method, double value, const char* unit, const std::string& settings,
           const char* reference) {
  Row r;
  r.name = "Z-width", r.method = method, r.settings = settings;
  r.error = value, r.error_unit = unit, r.reference = reference;
  return r;
}

}  // namespace

void add_z_width(SuiteOutcome& out, bool quick, const std::function<void(const std::string&)>& progress) {
  LineChart chart;
  chart.description = "The stiffness that a device of 150 g holds, against the damping of the wall";
  chart.x.title = "damping of the wall, N s/mm";
  chart.y = {.title = "stiffness held, N/mm", .log = true, .min = 0.1, .max = 30};
  const std::vector<double> dampings =
      quick ? std::vector<double>{0, 0.0015} : std::vector<double>{0, 0.0005, 0.001, 0.0015, 0.002, 0.003, 0.005};
  ChartSeries colgate{.name = "passive with any hand (Colgate)", .x = {}, .y = {}};
  for (const double B : {0.0, 0.0002, 0.0004, 0.0006, 0.0008, 0.0009, 0.00095})
    colgate.x.push_back(B), colgate.y.push_back(passive_bound_N_mm(kOwn, B));
  chart.series.push_back(colgate);
  double worst = 0, gained = 1e9;
  for (const int late : {0, 2}) {
    if (progress) progress(fmt::format("Z-width, {} ms late", late));
    const std::string name = late == 0 ? "no delay" : "2 ms late";
    ChartSeries bound{.name = "bound, " + name, .x = {}, .y = {}};
    ChartSeries held{.name = "held, " + name, .x = {}, .y = {}, .markers = true};
    ChartSeries controlled{.name = "held with the observer, " + name, .x = {}, .y = {}, .markers = true};
    for (const double B : dampings) {
      WallTrial t;
      t.device_damping_N_s_mm = kOwn, t.damping_N_s_mm = B, t.faults.reading_late = late, t.passivity = false;
      const double b = stable_stiffness_N_mm(kOwn, B, late * 1e-3), raw = stiffness_held(t);
      t.passivity = true;
      const double with = stiffness_held(t);
      bound.x.push_back(B), bound.y.push_back(b);
      held.x.push_back(B), held.y.push_back(raw);
      controlled.x.push_back(B), controlled.y.push_back(with);
      if (B == 0) worst = std::max(worst, std::abs(raw / b - 1));
      gained = std::min(gained, with / raw);
      out.result.rows.push_back(row_of(fmt::format("{}, damping {:.4f} N s/mm", name, B), raw, "N/mm",
                                       fmt::format("bound {:.2f}, passive {:.2f}; with the observer {:.2f} N/mm", b,
                                                   passive_bound_N_mm(kOwn, B), with),
                                       "the largest stiffness held without the observer"));
    }
    chart.series.push_back(bound), chart.series.push_back(held), chart.series.push_back(controlled);
  }
  out.charts.emplace_back("Z-width: the stiffness that a force device holds", chart);
  if (progress) progress("passivity under faults");
  struct Line {
    const char* name;
    LinkFaults faults;
  };
  const Line lines[] = {
      {"a good line", {}},
      {"steps of 0.05 mm", {.encoder_mm = 0.05}},
      {"2 ms late", {.reading_late = 1, .force_late = 1, .encoder_mm = 0.01}},
      {"5 ms late", {.reading_late = 3, .force_late = 2, .encoder_mm = 0.01}},
      {"2 % of ticks begin a loss of 5 ms", {.encoder_mm = 0.01, .lost = 0.02}},
      {"2 ms late, steps of 0.05 mm, losses", {.reading_late = 1, .force_late = 1, .encoder_mm = 0.05, .lost = 0.02}}};
  double least = 0;
  for (const Line& line : lines) {
    WallTrial t;
    t.faults = line.faults, t.device_damping_N_s_mm = kOwn, t.damping_N_s_mm = 0.0015;
    const int late = line.faults.reading_late + line.faults.force_late;
    const double bound = stable_stiffness_N_mm(kOwn, t.damping_N_s_mm, late * 1e-3);
    double with[2], without[2];
    for (const int stiff : {0, 1}) {
      t.wall_N_mm = (stiff ? 3 : 0.7) * bound;
      t.passivity = true, with[stiff] = wall_trial(t).least_energy_mJ;
      t.passivity = false, without[stiff] = wall_trial(t).least_energy_mJ;
    }
    least = std::min(least, with[0]);
    Row r = row_of(line.name, with[0], "mJ",
                   fmt::format("{:.2f} N/mm; without the observer {:.2f} mJ. At {:.1f} N/mm {:.1f}, without {:.0f} mJ",
                               0.7 * bound, without[0], 3 * bound, with[1], without[1]),
                   "least energy that the hand has put in, net");
    r.name = "passivity under faults";
    out.result.rows.push_back(r);
  }
  out.result.bars.push_back({"Z-width without damping: distance from the bound", worst, false, 0.12, false,
                             worst <= 0.12, "steps of 8 %; a mass that bounces spends time in the air"});
  out.result.bars.push_back({"Z-width: the observer's gain of stiffness, at least", gained, false, 1.4, true,
                             gained >= 1.4, "more than the sampled spring holds by itself"});
  out.result.bars.push_back({"passivity under faults, at 0.7 of the bound: mJ", least, false, -1.5, true, least >= -1.5,
                             "the observer's spare of 0.1 mJ, and a bounce before the line tells"});
}

}  // namespace limberg::bench
