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

RangeRow range_of(const LaneOfReport& lane) {
  RangeRow row;
  row.name = lane.name;
  row.median = row.low = in_ms(lane, lane.t.p50);
  row.high = in_ms(lane, lane.t.p99 ? lane.t.p99 : lane.t.p95);
  row.extreme = in_ms(lane, lane.t.max);
  row.budget = lane.budget_ms;
  row.colour = lane.colour;
  return row;
}

std::string counts(const ReportData& d) {
  std::vector<std::string> facts;
  const auto fact = [&](const MaybeCount& n, const char* of) {
    if (n) facts.push_back(number(double(*n), 9) + of);
  };
  fact(d.device.ticks, " device ticks");
  fact(d.device.late_ticks, " late by more than 1\u202fms");
  if (d.device.late_ticks && d.device.ticks && *d.device.ticks > 0)
    facts.back() += " (" + number(100 * double(*d.device.late_ticks) / double(*d.device.ticks), 2) + "\u202f%)";
  fact(d.device.events_lost, " events lost");
  fact(d.solver.steps, " solver steps");
  fact(d.render.frames, " frames");
  if (d.memory_mb) facts.push_back("peak memory " + quantity(d.memory_mb, "MB"));
  return joined(facts, " · ");
}

}  // namespace

html::Markup timing(const ReportSource& source) {
  const ReportData& d = source.d;
  RangeChart chart;
  chart.description = "Times of the device, solver and render lanes";
  chart.x.title = "ms (logarithmic)", chart.x.log = true;
  std::vector<html::Row> rows;
  for (const LaneOfReport& lane : lanes_of(d)) {
    if (!lane.t.any()) continue;
    html::Row row{lane.name};
    for (const Maybe& v : {lane.t.p50, lane.t.p95, lane.t.p99, lane.t.p999, lane.t.max})
      row.push_back(quantity(in_ms(lane, v), "ms"));
    row.push_back(quantity(lane.budget_ms, "ms"));
    rows.push_back(row);
    chart.rows.push_back(range_of(lane));
  }
  if (rows.empty()) return {};
  html::Markup body;
  if (d.mode == "lockstep")
    body += html::paragraph(
        "This run was driven in lockstep, on a virtual clock: steps and frames could take as long as they liked, and "
        "the times say what the work cost.");
  if (said(d.solver.hand) == "waits")
    body +=
        html::paragraph("The hand was emulated or recorded and waited for the patient: the session's clock stood for " +
                        quantity(d.solver.waited_ms, "ms") + " in all, so that no step was skipped.");
  if (said(d.solver.hand) == "slowed" && d.solver.slowest_pace)
    body += html::paragraph("The session ran in slow motion where the patient fell behind the hand: it lasted " +
                            quantity(d.solver.slowed_ms, "ms") + " longer than its own clock says, and its slowest " +
                            "second passed at " + number(*d.solver.slowest_pace, 2) + " of real time.");
  if (const std::string facts = counts(d); !facts.empty()) body += html::paragraph(facts);
  body += html::chart(svg(chart)) +
          html::note(
              "Bar: median (dot) to 99th percentile. Ring: worst. Upright line: the lane's budget (device 1\u202fkHz, "
              "solver 60\u202fHz, render 30\u202fHz).") +
          html::table({"Lane", "p50", "p95", "p99", "p99.9", "max", "budget"}, rows);
  return html::section("Three lanes in time", body);
}

}  // namespace limberg::sections
