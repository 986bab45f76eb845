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

// Reading by type: what is absent or of another type leaves the value as it is (empty).
void read(const Json& j, Maybe& v) { v = number(j); }
void read(const Json& j, MaybeCount& v) {
  if (j.is_number_integer()) v = j.get<int64_t>();
}
void read(const Json& j, double& v) { v = number(j).value_or(v); }
void read(const Json& j, bool& v) { v = j.is_boolean() && j.get<bool>(); }
void read(const Json& j, std::string& v) { v = words(j); }
void read(const Json& j, std::vector<double>& v) { v = column(j); }
template <ResultEntry T>
void read(const Json& j, T& entry);
template <class T>
requires(!std::is_same_v<T, double>) void read(const Json& j, std::vector<T>& list);

template <ResultEntry T>
void read(const Json& j, T& entry) {
  fields(entry, [&](const char* name, auto& v) { read(member(j, name), v); });
}
template <class T>
requires(!std::is_same_v<T, double>) void read(const Json& j, std::vector<T>& list) {
  if (!j.is_array()) return;
  for (const Json& e : j) {
    if (ResultEntry<T> && !e.is_object()) continue;
    read(e, list.emplace_back());
  }
}
/// Every number of an object by its name.
void read(const Json& j, std::map<std::string, double>& numbers, const std::string& before = "") {
  if (!j.is_object()) return;
  for (const auto& [name, value] : j.items())
    if (const Maybe v = number(value)) numbers[before + name] = *v;
}

void read_study(const Json& j, ReportData& d) {
  read(member(j, "study"), d.study);
  read(member(j, "about"), d.about);
  read(member(j, "columns"), d.study_columns);
  if (const Json& rows = member(j, "rows"); rows.is_array())
    for (const Json& r : rows) {
      auto& row = d.study_rows.emplace_back();
      for (const std::string& c : d.study_columns) row.push_back(number(r, c.c_str()));
    }
}

}  // namespace

ReportData read_report_data(const std::string& text, const std::string& file) {
  const Json j = parse(text, file);
  ReportData d;
  const Json& program = member(j, "limberg");
  d.version = program.is_string() ? words(program) : words(program, "version");
  d.commit = words(program, "commit");
  for (const auto& [name, v] :
       {std::pair("command", &d.command), std::pair("scene", &d.scene), std::pair("scene_title", &d.scene_title),
        std::pair("scene_note", &d.scene_note), std::pair("mode", &d.mode), std::pair("state_hash", &d.state_hash),
        std::pair("reproduce", &d.reproduce)})
    read(member(j, name), *v);
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
  read(member(device, "wake_us"), d.wake_us);
  read(member(device, "work_us"), d.work_us);
  read(member(solver, "step_ms"), d.step_ms);
  read(member(render, "frame_ms"), d.frame_ms);
  read(member(member(j, "latency_ms"), "sample_to_snapshot"), d.to_snapshot_ms);
  read(member(member(j, "latency_ms"), "sample_to_frame"), d.to_frame_ms);

  if (const Json& parts = member(j, "parts"); parts.is_array())
    for (const Json& p : parts)
      if (p.is_string()) d.parts.push_back(p.get<std::string>());
  if (const Json& lattice = member(j, "lattice"); lattice.is_object())
    for (const auto& [name, value] : lattice.items())
      if (const Maybe v = number(value)) d.lattice.emplace_back(name, *v);

  const Json& metrics = member(j, "metrics");
  read(metrics, d.metrics);
  read(member(metrics, "sutures"), d.sutures);
  read(member(metrics, "predicted"), d.predicted);
  read(member(metrics, "landmarks"), d.landmarks);

  if (const Json& stages = member(j, "stages"); stages.is_array())
    for (const Json& s : stages) {
      read(s, d.stages.emplace_back());
      if (s.is_string()) d.stages.back().name = s.get<std::string>();
    }

  const Json& pictures = member(j, "pictures");
  d.overview = words(pictures, "overview");
  d.tension = words(pictures, "tension");
  if (d.overview.empty()) d.overview = report_names::overview;
  if (d.tension.empty()) d.tension = report_names::tension;
  read(member(j, "gallery"), d.gallery);

  const Json& series = member(j, "series");
  d.series_t_s = column(member(series, "t_s"));
  d.series_residual = column(member(series, "residual"));
  d.series_distance_mm = column(member(series, "distance_mm"));
  d.series_closure_N = column(member(series, "closure_N"));
  d.series_suture_max_N = column(member(series, "suture_max_N"));

  if (const Json& balance = member(j, "balance"); balance.is_object())
    for (const auto& [name, value] : balance.items()) {
      if (name == "relative")
        d.balance_relative = number(value);
      else if (value.is_array() && value.size() == 3)
        d.balance.emplace_back(name, column(value));
    }
  read(member(j, "convergence"), d.convergence);
  if (const Json& errors = member(j, "discretisation"); errors.is_object())
    for (const auto& [name, e] : errors.items()) read(e, d.errors[name]);
  if (d.command == "study") read_study(j, d);
  if (d.command == "study" || d.command == "bench") read(member(j, "bars"), d.bars);

  read(member(j, "charts"), d.charts);
  for (ResultChart& c : d.charts) {
    std::erase_if(c.series, [](const ResultChart::Series& s) { return s.x.size() != s.y.size(); });
    // A mark without a value is none.
    for (auto* marks : {&c.x_marks, &c.y_marks})
      std::erase_if(*marks, [](const ResultMark& m) { return !std::isfinite(m.value); });
  }
  read(member(j, "tables"), d.tables);

  const Json& exercise = member(j, "exercise");
  read(exercise, d.exercise);
  read(member(exercise, "design"), d.exercise, "design/");
  const Json& lesson = member(j, "lesson");
  d.lesson_title = words(lesson, "title");
  d.lesson_goal = words(lesson, "goal");
  read(member(lesson, "tolerances"), d.tolerances);
  read(member(lesson, "hints"), d.hints);

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
