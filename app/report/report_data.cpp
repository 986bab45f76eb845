#include "app/report/report_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/report/report_names.h"
#include "app/report/script_words.h"
#include "app/result/json_nesting.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

using Json = nlohmann::json;

// The member, or null when j is no object or has none.
const Json& member(const Json& j, const char* name) {
  static const Json nothing;
  if (!j.is_object()) return nothing;
  const auto it = j.find(name);
  return it == j.end() ? nothing : *it;
}

Maybe number(const Json& j) {
  return j.is_number() && std::isfinite(j.get<double>()) ? Maybe(j.get<double>()) : Maybe();
}
Maybe number(const Json& j, const char* name) { return number(member(j, name)); }

// Words or a number as words; never a structure.
std::string words(const Json& j) {
  if (j.is_string()) return j.get<std::string>();
  return j.is_number() || j.is_boolean() ? j.dump() : std::string();
}
std::string words(const Json& j, const char* name) { return words(member(j, name)); }

ReportTimes times(const Json& j) {
  return {number(j, "p50"), number(j, "p95"), number(j, "p99"), number(j, "p999"), number(j, "max")};
}

std::vector<double> column(const Json& j) {
  std::vector<double> v;
  if (j.is_array())
    for (const Json& e : j) v.push_back(number(e).value_or(std::numeric_limits<double>::quiet_NaN()));
  return v;
}

int line_of(const std::string& text, size_t byte) {
  return 1 + int(std::count(text.begin(), text.begin() + std::ptrdiff_t(std::min(byte, text.size())), '\n'));
}

Json parse(const std::string& text, const std::string& file) {
  if (json_nesting(text) > 64) throw InputError(file, 0, "nests deeper than 64 levels; expected the result of a run");
  Json j;
  try {
    j = Json::parse(text);
  } catch (const Json::parse_error& e) {
    throw InputError(file, line_of(text, e.byte ? e.byte - 1 : 0), "is not JSON; expected the result of a run");
  } catch (const Json::exception&) {
    throw InputError(file, 0, "holds a number that is out of range; expected the result of a run");
  }
  if (!j.is_object()) throw InputError(file, 1, "is JSON but no object; expected the result of a run");
  return j;
}

void read_metrics(const Json& m, ReportData& d) {
  if (!m.is_object()) return;
  for (const auto& [name, value] : m.items())
    if (const Maybe v = number(value)) d.metrics[name] = *v;
  const Json& sutures = member(m, "sutures");
  if (sutures.is_array())
    for (const Json& s : sutures)
      if (s.is_object())
        d.sutures.push_back(
            {words(s, "id"), number(s, "force_N"), number(s, "gap_mm"), number(s, "tied_N"), number(s, "peak_N")});
  if (const Json& points = member(m, "predicted"); points.is_array())
    for (const Json& p : points)
      d.predicted.push_back({number(p, "charge_deg"), number(p, "x_mm"), number(p, "y_mm"), number(p, "height_mm"),
                             number(p, "volume_mm3"), number(p, "deficit_deg")});
  if (const Json& marks = member(m, "landmarks"); marks.is_array())
    for (const Json& l : marks)
      d.landmarks.push_back(
          {words(l, "name"),
           {number(l, "displacement_mm"), number(l, "along_mm"), number(l, "across_mm"), number(l, "up_mm")}});
}

void read_charts(const Json& j, ReportData& d) {
  const auto truth = [](const Json& v) { return v.is_boolean() && v.get<bool>(); };
  if (const Json& charts = member(j, "charts"); charts.is_array())
    for (const Json& c : charts) {
      ReportChart chart{words(c, "title"),
                        words(c, "description"),
                        words(c, "x"),
                        words(c, "y"),
                        {},
                        truth(member(c, "x_log")),
                        truth(member(c, "y_log")),
                        {},
                        {}};
      if (const Json& series = member(c, "series"); series.is_array())
        for (const Json& s : series) {
          ReportChart::Series one{words(s, "name"), column(member(s, "x")), column(member(s, "y")),
                                  truth(member(s, "markers"))};
          if (one.x.size() == one.y.size()) chart.series.push_back(std::move(one));
        }
      for (const auto& [key, marks] : {std::pair("x_marks", &chart.x_marks), std::pair("y_marks", &chart.y_marks)})
        if (const Json& list = member(c, key); list.is_array())
          for (const Json& m : list)
            if (const Maybe v = number(m, "value")) marks->emplace_back(*v, words(m, "label"));
      d.charts.push_back(std::move(chart));
    }
}

void read_exercise(const Json& j, ReportData& d) {
  const Json& e = member(j, "exercise");
  if (e.is_object())
    for (const auto& [name, value] : e.items()) {
      if (const Maybe v = number(value)) d.exercise[name] = *v;
      if (name == "design" && value.is_object())
        for (const auto& [k, x] : value.items())
          if (const Maybe v = number(x)) d.exercise["design/" + k] = *v;
    }
  const Json& l = member(j, "lesson");
  d.lesson_title = words(l, "title");
  d.lesson_goal = words(l, "goal");
  if (const Json& t = member(l, "tolerances"); t.is_array())
    for (const Json& x : t) {
      const Json& met = member(x, "met");
      d.tolerances.push_back({words(x, "name"), words(x, "unit"), number(x, "limit"), number(x, "value"),
                              met.is_boolean() && met.get<bool>(), words(x, "why")});
    }
  if (const Json& h = member(l, "hints"); h.is_array())
    for (const Json& x : h) d.hints.push_back(words(x));
  if (const Json& tables = member(j, "tables"); tables.is_array())
    for (const Json& t : tables) {
      ReportTable table{words(t, "title"), words(t, "about"), {}, {}};
      if (const Json& c = member(t, "columns"); c.is_array())
        for (const Json& x : c) table.columns.push_back(words(x));
      if (const Json& rows = member(t, "rows"); rows.is_array())
        for (const Json& r : rows) {
          auto& row = table.rows.emplace_back();
          if (r.is_array())
            for (const Json& x : r) row.push_back(words(x));
        }
      d.tables.push_back(std::move(table));
    }
}

void read_stages(const Json& j, ReportData& d) {
  if (!j.is_array()) return;
  for (const Json& s : j) {
    ReportStage r;
    r.name = s.is_string() ? s.get<std::string>() : words(s, "name");
    r.picture = words(s, "picture");
    r.caption = words(s, "caption");
    r.t_s = number(s, "t_s");
    r.residual = number(s, "residual");
    r.sutures = number(s, "sutures");
    r.pieces = number(s, "pieces");
    d.stages.push_back(r);
  }
}

void read_study(const Json& j, ReportData& d) {
  d.study = words(j, "study");
  d.about = words(j, "about");
  if (const Json& columns = member(j, "columns"); columns.is_array())
    for (const Json& c : columns) d.study_columns.push_back(words(c));
  if (const Json& rows = member(j, "rows"); rows.is_array())
    for (const Json& r : rows) {
      auto& row = d.study_rows.emplace_back();
      for (const std::string& c : d.study_columns) row.push_back(number(r, c.c_str()));
    }
}

/// Of a study or a bench.
void read_bars(const Json& j, ReportData& d) {
  const auto truth = [](const Json& v) { return v.is_boolean() && v.get<bool>(); };
  if (const Json& bars = member(j, "bars"); bars.is_array())
    for (const Json& b : bars)
      d.bars.push_back({words(b, "name"), words(b, "source"), number(b, "value"), number(b, "bar"),
                        truth(member(b, "larger_is_better")), truth(member(b, "pass"))});
}

}  // namespace

ReportData read_report_data(const std::string& text, const std::string& file) {
  const Json j = parse(text, file);
  ReportData d;
  const Json& program = member(j, "limberg");
  d.version = program.is_string() ? words(program) : words(program, "version");
  d.commit = words(program, "commit");
  d.command = words(j, "command");
  d.scene = words(j, "scene");
  d.scene_title = words(j, "scene_title");
  d.scene_note = words(j, "scene_note");
  d.mode = words(j, "mode");
  d.state_hash = words(j, "state_hash");
  d.reproduce = words(j, "reproduce");
  d.cpu = words(member(j, "machine"), "cpu");
  d.cores = number(member(j, "machine"), "cores");
  if (const Json& ok = member(j, "ok"); ok.is_boolean()) d.ok = ok.get<bool>();

  const Json &device = member(j, "device"), &solver = member(j, "solver"), &render = member(j, "render");
  d.duration_s = number(j, "duration_s");
  d.memory_mb = number(j, "memory_mb");
  d.solve_ms = number(j, "solve_ms");
  d.residual = number(solver, "residual");
  if (!d.residual) d.residual = number(j, "residual");
  d.distance_mm = number(solver, "distance_mm");
  if (!d.distance_mm) d.distance_mm = number(j, "distance_mm");
  d.solver_steps = number(solver, "steps");
  d.render_frames = number(render, "frames");
  d.device_ticks = number(device, "ticks");
  d.late_ticks = number(device, "late_ticks");
  d.events_lost = number(device, "events_lost");
  d.wake_us = times(member(device, "wake_us"));
  d.work_us = times(member(device, "work_us"));
  d.step_ms = times(member(solver, "step_ms"));
  d.frame_ms = times(member(render, "frame_ms"));
  d.to_snapshot_ms = times(member(member(j, "latency_ms"), "sample_to_snapshot"));
  d.to_frame_ms = times(member(member(j, "latency_ms"), "sample_to_frame"));

  if (const Json& parts = member(j, "parts"); parts.is_array())
    for (const Json& p : parts)
      if (p.is_string()) d.parts.push_back(p.get<std::string>());
  if (const Json& lattice = member(j, "lattice"); lattice.is_object())
    for (const auto& [name, value] : lattice.items())
      if (const Maybe v = number(value)) d.lattice.emplace_back(name, *v);
  read_metrics(member(j, "metrics"), d);
  read_stages(member(j, "stages"), d);

  const Json& pictures = member(j, "pictures");
  d.overview = words(pictures, "overview");
  d.tension = words(pictures, "tension");
  if (d.overview.empty()) d.overview = report_names::overview;
  if (d.tension.empty()) d.tension = report_names::tension;

  if (const Json& g = member(j, "gallery"); g.is_array())
    for (const Json& e : g)
      if (e.is_object()) d.gallery.emplace_back(words(e, "picture"), words(e, "caption"));

  const Json& series = member(j, "series");
  d.series_t_s = column(member(series, "t_s"));
  d.series_residual = column(member(series, "residual"));
  d.series_distance_mm = column(member(series, "distance_mm"));

  if (const Json& balance = member(j, "balance"); balance.is_object())
    for (const auto& [name, value] : balance.items()) {
      if (name == "relative")
        d.balance_relative = number(value);
      else if (value.is_array() && value.size() == 3)
        d.balance.emplace_back(name, column(value));
    }
  if (const Json& rows = member(j, "convergence"); rows.is_array())
    for (const Json& r : rows)
      d.convergence.push_back({number(r, "cell_mm"), number(r, "nodes"), number(r, "closure_force_N"),
                               number(r, "suture_gap_max_mm"), number(r, "suture_force_max_N"), number(r, "dog_ear_mm"),
                               number(r, "residual"), number(r, "solve_ms")});
  if (const Json& errors = member(j, "discretisation"); errors.is_object())
    for (const auto& [name, e] : errors.items()) {
      const Json& known = member(e, "asymptotic");
      d.errors[name] = {number(e, "value"),
                        number(e, "error"),
                        number(e, "order"),
                        number(e, "extrapolated"),
                        known.is_boolean() && known.get<bool>(),
                        words(e, "says")};
    }
  if (d.command == "study") read_study(j, d);
  if (d.command == "study" || d.command == "bench") read_bars(j, d);
  read_charts(j, d);
  read_exercise(j, d);
  d.series_closure_N = column(member(series, "closure_N"));
  d.series_suture_max_N = column(member(series, "suture_max_N"));
  if (const Json& script = member(j, "script"); script.is_array())
    for (const Json& l : script) d.script.push_back(l.is_string() ? l.get<std::string>() : l.dump());
  // A stage without words of its own says what the script did since the stage before.
  const auto words_of = stage_words(d.script);
  for (size_t i = 0; i < std::min(d.stages.size(), words_of.size()); ++i)
    if (d.stages[i].caption.empty() && d.stages[i].name == words_of[i].first) d.stages[i].caption = words_of[i].second;
  if (const Json& damage = member(j, "damage"); damage.is_object())
    for (const auto& [name, value] : damage.items())
      d.damage.emplace_back(name, value.is_structured() ? value.dump() : words(value));
  return d;
}

}  // namespace limberg
