// How the program fared: mesh, timing, convergence, and how to make the result again.
#include <algorithm>
#include <cmath>

#include "app/report/html.h"
#include "app/report/sections.h"
#include "app/report/svg_chart.h"

namespace limberg::sections {

using html::escape;
using html::number;
using html::quantity;

std::string convergence(const ReportData& d) {
  if (d.convergence.empty()) return {};
  struct Column {
    const char *name, *unit;
    Maybe (*value)(const ResultConvergence&);
    bool difference;
  };
  const Column columns[] = {
      {"Cell", "mm", [](const ResultConvergence& r) { return r.cell_mm; }, false},
      {"Lattice nodes", "", [](const ResultConvergence& r) { return r.nodes ? Maybe(double(*r.nodes)) : Maybe(); },
       false},
      {"Closure force", "N", [](const ResultConvergence& r) { return r.closure_force_N; }, true},
      {"Largest suture force", "N", [](const ResultConvergence& r) { return r.suture_force_max_N; }, true},
      {"Largest gap", "mm", [](const ResultConvergence& r) { return r.suture_gap_max_mm; }, true},
      {"Dog-ear", "mm", [](const ResultConvergence& r) { return r.dog_ear_mm; }, true},
      {"Residual", "", [](const ResultConvergence& r) { return r.residual; }, false},
      {"Solve", "ms", [](const ResultConvergence& r) { return r.solve_ms; }, false}};
  std::string head, body;
  const auto present = [&](const Column& c) {
    return std::any_of(d.convergence.begin(), d.convergence.end(),
                       [&](const ResultConvergence& r) { return bool(c.value(r)); });
  };
  for (const Column& c : columns)
    if (present(c)) head += "<th>" + std::string(c.name) + "</th>";
  for (size_t i = 0; i < d.convergence.size(); ++i) {
    body += "<tr>";
    for (const Column& c : columns) {
      if (!present(c)) continue;
      const Maybe v = c.value(d.convergence[i]);
      body += "<td>" + (c.unit[0] == 0 && v && *v >= 1 ? number(*v, 7) : quantity(v, c.unit));
      if (c.difference && v && i > 0 && c.value(d.convergence[i - 1])) {  // how much finer cells changed it
        const double change = *v - *(c.value(d.convergence[i - 1]));
        body += " <span class=\"soft\">(" + std::string(change > 0 ? "+" : "") + number(change, 2) + ")</span>";
      }
      body += "</td>";
    }
    body += "</tr>\n";
  }
  std::string errors;
  for (const auto& [name, e] : d.errors)
    errors += "<tr><td><code>" + escape(name) + "</code></td><td>" + quantity(e.value, "") + "</td><td>" +
              quantity(e.error, "", 2) + "</td><td>" + quantity(e.extrapolated, "") + "</td><td>" +
              quantity(e.order, "", 2) + "</td><td class=\"soft\">" + escape(e.says) + "</td></tr>\n";
  if (!errors.empty())
    errors =
        "<p>What the lattice does to each figure: the finest value, its estimated error (grid convergence index), and "
        "what it tends to as the cells "
        "shrink. Where the sizes are not in the asymptotic range nothing is extrapolated, and the error is three times "
        "the largest change.</p>\n"
        "<div "
        "class=\"wide\"><table>\n<thead><tr><th>Figure</th><th>finest</th><th>±</th><th>limit</th><th>order</th><th></"
        "th></tr></thead>\n<tbody>\n" +
        errors + "</tbody></table></div>\n";
  return "<section>\n<h2>Finer cells, same answer?</h2>\n<p>The same script at several lattice sizes. In brackets: "
         "change against the row above; "
         "it should shrink.</p>\n<div class=\"wide\"><table>\n<thead><tr>" +
         head + "</tr></thead>\n<tbody>\n" + body + "</tbody></table></div>\n" + errors + "</section>\n";
}

std::string timing(const ReportData& d) {
  struct Lane {
    const char* name;
    const ResultTimes* t;
    double to_ms;
    Maybe budget_ms;
    int colour;
  };
  const Lane lanes[] = {
      {"Device: wake-up late by", &d.wake_us, 1e-3, 1.0, 1}, {"Device: work per tick", &d.work_us, 1e-3, 1.0, 1},
      {"Solver: one step", &d.step_ms, 1, 1000.0 / 60, 2},   {"Render: one frame", &d.frame_ms, 1, 1000.0 / 30, 3},
      {"Sample to snapshot", &d.to_snapshot_ms, 1, {}, 4},   {"Sample to picture", &d.to_frame_ms, 1, {}, 4}};
  RangeChart chart;
  chart.description = "Times of the device, solver and render lanes";
  chart.x = {"ms (logarithmic)", true, {}, {}};
  std::string rows;
  for (const Lane& lane : lanes) {
    if (!lane.t->any()) continue;
    const auto ms = [&](const Maybe& v) { return v ? Maybe(*v * lane.to_ms) : v; };
    const auto cell = [&](const Maybe& v) { return "<td>" + quantity(ms(v), "ms") + "</td>"; };
    rows += "<tr><td>" + std::string(lane.name) + "</td>" + cell(lane.t->p50) + cell(lane.t->p95) + cell(lane.t->p99) +
            cell(lane.t->p999) + cell(lane.t->max) + "<td>" + quantity(lane.budget_ms, "ms") + "</td></tr>\n";
    RangeRow row;
    row.name = lane.name;
    row.median = row.low = ms(lane.t->p50), row.high = ms(lane.t->p99 ? lane.t->p99 : lane.t->p95),
    row.extreme = ms(lane.t->max);
    row.budget = lane.budget_ms;
    row.colour = lane.colour;
    chart.rows.push_back(row);
  }
  if (rows.empty()) return {};
  std::string s = "<section>\n<h2>Three lanes in time</h2>\n";
  if (d.mode == "lockstep")
    s += "<p>This run was driven in lockstep, on a virtual clock: steps and frames could take as long as they liked, "
         "and the times say what the work cost.</p>\n";
  std::string facts;
  const auto fact = [&](const std::string& f) { facts += (facts.empty() ? "" : " · ") + f; };
  if (d.device_ticks) fact(number(*d.device_ticks, 9) + " device ticks");
  if (d.late_ticks) {
    std::string share;
    if (d.device_ticks && *d.device_ticks > 0)
      share = " (" + number(100 * *d.late_ticks / *d.device_ticks, 2) + "\u202f%)";
    fact(number(*d.late_ticks, 9) + " late by more than 1\u202fms" + share);
  }
  if (d.events_lost) fact(number(*d.events_lost, 9) + " events lost");
  if (d.solver_steps) fact(number(*d.solver_steps, 9) + " solver steps");
  if (d.render_frames) fact(number(*d.render_frames, 9) + " frames");
  if (d.memory_mb) fact("peak memory " + quantity(d.memory_mb, "MB"));
  if (!facts.empty()) s += "<p>" + facts + "</p>\n";
  s += "<div class=\"wide\">" + svg(chart) +
       "</div>\n<p class=\"note\">Bar: median (dot) to 99th percentile. Ring: worst. Upright line: the lane's budget "
       "(device 1\u202fkHz, solver 60\u202fHz, "
       "render 30\u202fHz).</p>\n<div "
       "class=\"wide\"><table>\n<thead><tr><th>Lane</th><th>p50</th><th>p95</th><th>p99</th><th>p99.9</th><th>max</"
       "th><th>budget</th></tr></thead>\n<tbody>\n" +
       rows + "</tbody></table></div>\n</section>\n";
  return s;
}

std::string residual(const ReportData& d) {
  const size_t n = std::max(d.series_residual.size(), d.series_distance_mm.size());
  if (n < 2) return {};
  std::vector<double> t = d.series_t_s;
  const bool timed = t.size() >= n;
  if (!timed) {
    t.resize(n);
    for (size_t i = 0; i < n; ++i) t[i] = double(i);
  }
  LineChart chart;
  chart.x = {timed ? "time of the recording, s" : "solver step", false, {}, {}};
  std::string s =
      "<section>\n<h2>How close to equilibrium</h2>\n<p>The relative residual is the size of the unbalanced forces "
      "over that of all internal "
      "forces. Each action throws it up; the solver brings it down.</p>\n";
  if (d.series_residual.size() > 1) {
    chart.description = "Relative residual over time";
    chart.y = {"relative residual", true, {}, {}};
    chart.series = {{"residual", t, d.series_residual, false}};
    chart.y_marks = {{kAtRest, "goal"}};
    for (const ResultStage& stage : d.stages)
      if (stage.t_s && timed) chart.x_marks.push_back({*stage.t_s, stage.name.substr(0, 24)});
    s += "<div class=\"wide\">" + svg(chart) + "</div>\n";
  }
  if (d.series_distance_mm.size() > 1) {
    chart.description = "Estimated distance to equilibrium over time";
    s += "<p>The largest distance of any node from where it will come to rest, as every frame estimates it while it "
         "works.</p>\n";
    chart.y = {"estimated distance, mm", true, {}, {}};
    chart.series = {{"distance", t, d.series_distance_mm, false}};
    chart.y_marks.clear();
    chart.height = 240;
    s += "<div class=\"wide\">" + svg(chart) + "</div>\n";
  }
  return s + "</section>\n";
}

std::string figures(const ReportData& d) {
  std::string rows;
  for (const auto& [name, v] : d.metrics) {
    const auto e = d.errors.find(name);
    rows += "<tr><td><code>" + escape(name) + "</code></td><td>" + number(v, 6) + "</td>";
    if (!d.errors.empty())
      rows += "<td>" + (e == d.errors.end() ? std::string() : quantity(e->second.error, "", 2)) + "</td>";
    rows += "</tr>\n";
  }
  for (const auto& [name, v] : d.lattice)
    rows += "<tr><td><code>lattice." + escape(name) + "</code></td><td>" + number(v, 6) + "</td></tr>\n";
  if (d.solve_ms) rows += "<tr><td><code>solve_ms</code></td><td>" + number(*d.solve_ms, 6) + "</td></tr>\n";
  if (rows.empty()) return {};
  return "<section>\n<h2>All figures</h2>\n<p class=\"note\">Units stand in the names; a name without a unit is a "
         "ratio or a count." +
         std::string(d.errors.empty() ? "" : " Third column: the lattice's share of the error, where it is known.") +
         "</p>\n<div class=\"wide\"><table>\n<tbody>\n" + rows + "</tbody></table></div>\n</section>\n";
}

std::string script(const ReportData& d) {
  std::string s;
  if (!d.script.empty()) {
    s += "<section>\n<h2>The script of the operation</h2>\n<p class=\"note\">One action a line; " +
         std::string(
             d.of_bones()
                 ? "points are millimetres in the frame of the scan. <code>limberg operate</code> does it again."
                 : "points are millimetres on the skin. <code>limberg operate</code> runs it at any resolution.") +
         "</p>\n<pre>";
    for (const std::string& line : d.script) s += escape(line) + "\n";
    s += "</pre>\n</section>\n";
  }
  if (!d.reproduce.empty())
    s += "<section>\n<h2>Make it again</h2>\n<pre>" + escape(d.reproduce) + "</pre>\n" +
         (d.state_hash.empty() ? "" : "<p class=\"note\">State hash: <code>" + escape(d.state_hash) + "</code></p>\n") +
         "</section>\n";
  return s;
}

std::string footer(const ReportData& d) {
  std::string s;
  const auto part = [&](const std::string& p) { s += (s.empty() ? "" : " · ") + p; };
  if (!d.version.empty())
    part("limberg " + escape(d.version) + (d.commit.empty() ? "" : " (" + escape(d.commit) + ")"));
  if (!d.cpu.empty()) part(escape(d.cpu) + (d.cores ? ", " + number(*d.cores) + " cores" : ""));
  if (!d.parts.empty()) {
    std::string list;
    for (const std::string& p : d.parts) list += (list.empty() ? "" : ", ") + escape(p);
    part("built: " + list);
  }
  if (d.reproduce.empty() && !d.state_hash.empty()) part("state " + escape(d.state_hash));
  return s.empty() ? s : "<footer>" + s + "</footer>\n";
}

}  // namespace limberg::sections
