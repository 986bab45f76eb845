// What the device, solver and render lanes cost, beside their budgets.
#include "app/report/html.h"
#include "app/report/sections.h"

namespace limberg::sections {

using html::number;
using html::quantity;

namespace {

/// Of a time of the lane, in the lane's unit.
Maybe in_ms(const LaneOfReport& lane, const Maybe& t) {
  return t ? Maybe(*t * (std::string_view(lane.unit) == "µs" ? 1e-3 : 1)) : t;
}

RangeRow range_of(const LaneOfReport& lane, const Words& w) {
  RangeRow row;
  row.name = w(lane.name);
  row.median = row.low = in_ms(lane, lane.t.p50);
  row.high = in_ms(lane, lane.t.p99 ? lane.t.p99 : lane.t.p95);
  row.extreme = in_ms(lane, lane.t.max);
  row.budget = lane.budget_ms;
  row.colour = lane.colour;
  return row;
}

std::string counts(const ReportData& d) {
  const Words& w = d.w;
  std::vector<std::string> facts;
  const auto told = [](const MaybeCount& n) { return number(double(*n), 9); };
  if (d.device.ticks) facts.push_back(w("{} device ticks", told(d.device.ticks)));
  if (d.device.late_ticks) facts.push_back(w("{} late by more than 1 ms", told(d.device.late_ticks)));
  if (d.device.late_ticks && d.device.ticks && *d.device.ticks > 0)
    facts.back() += " (" + number(100 * double(*d.device.late_ticks) / double(*d.device.ticks), 2) + "\u202f%)";
  if (d.device.events_lost) facts.push_back(w("{} events lost", told(d.device.events_lost)));
  if (d.solver.steps) facts.push_back(w("{} solver steps", told(d.solver.steps)));
  if (d.render.frames) facts.push_back(w("{} frames", told(d.render.frames)));
  if (d.memory_mb) facts.push_back(w("peak memory {}", quantity(d.memory_mb, "MB")));
  return joined(facts, " · ");
}

}  // namespace

html::Markup timing(const ReportSource& source) {
  const ReportData& d = source.d;
  const Words& w = d.w;
  RangeChart chart;
  chart.description = w("Times of the device, solver and render lanes");
  chart.x.title = w("ms (logarithmic)"), chart.x.log = true;
  std::vector<html::Row> rows;
  for (const LaneOfReport& lane : lanes_of(d)) {
    if (!lane.t.any()) continue;
    html::Row row{w(lane.name)};
    for (const Maybe& v : {lane.t.p50, lane.t.p95, lane.t.p99, lane.t.p999, lane.t.max})
      row.push_back(quantity(in_ms(lane, v), "ms"));
    row.push_back(quantity(lane.budget_ms, "ms"));
    rows.push_back(row);
    chart.rows.push_back(range_of(lane, w));
  }
  if (rows.empty()) return {};
  html::Markup body;
  if (d.mode == "lockstep")
    body += html::paragraph(
        w("This run was driven in lockstep, on a virtual clock: steps and frames could take as long as they liked, and "
          "the times say what the work cost."));
  if (said(d.solver.hand) == "waits")
    body +=
        html::paragraph(w("The hand was emulated or recorded and waited for the patient: the session's clock stood for "
                          "{} in all, so that no step was skipped.",
                          quantity(d.solver.waited_ms, "ms")));
  if (said(d.solver.hand) == "slowed" && d.solver.slowest_pace)
    body +=
        html::paragraph(w("The session ran in slow motion where the patient fell behind the hand: it lasted {} "
                          "longer than its own clock says, and its slowest second passed at {} of real time.",
                          quantity(d.solver.slowed_ms, "ms"), number(*d.solver.slowest_pace, 2)));
  if (const std::string facts = counts(d); !facts.empty()) body += html::paragraph(facts);
  body +=
      html::chart(svg(chart)) +
      html::note(w("Bar: median (dot) to 99th percentile. Ring: worst. Upright line: the lane's budget (device 1 kHz, "
                   "solver 60 Hz, render 30 Hz).")) +
      html::table({w("Lane"), "p50", "p95", "p99", "p99.9", "max", w("budget")}, rows);
  return html::section(w("Three lanes in time"), body);
}

}  // namespace limberg::sections
