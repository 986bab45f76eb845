#include "app/class/class_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "app/assembly/lesson.h"

namespace limberg {
namespace {

std::string text_of(const Maybe& v) { return v && std::isfinite(*v) ? fmt::format("{:.6g}", *v) : std::string(); }
std::string text_of(const MaybeCount& v) { return v ? std::to_string(*v) : std::string(); }

struct Columns {
  const std::vector<ClassRow>& rows;
  std::vector<ClassColumn> all;
  void add(const std::string& name, const std::string& unit, const std::string& meaning,
           const std::function<std::string(const ClassRow&)>& value) {
    ClassColumn c{name, unit, meaning, {}};
    for (const ClassRow& r : rows) c.value.push_back(value(r));
    all.push_back(std::move(c));
  }
  void add_exercise(const char* name, const char* unit, const char* meaning) {
    add(name, unit, meaning, [name](const ClassRow& r) { return text_of(exercise_of(r.member.result, name)); });
  }
  void add_metric(const char* name, const char* unit, const char* meaning) {
    add(name, unit, meaning, [name](const ClassRow& r) { return text_of(r.member.result.metric(name)); });
  }
};

/// "flap_cut" of "flap cut".
std::string column_name(const std::string& words) {
  std::string s;
  for (const char c : words) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (letter || (c >= 'A' && c <= 'Z'))
      s += letter ? c : char(c - 'A' + 'a');
    else if (!s.empty() && s.back() != '_')
      s += '_';
  }
  while (!s.empty() && s.back() == '_') s.pop_back();
  return s.substr(0, 40);
}

}  // namespace

ClassForces forces_of(const ClassMember& m) {
  ClassForces f;
  const std::vector<ResultSuture>& all = m.result.sutures();
  double sum = 0;
  int n = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    const ResultSuture& s = all[i];
    if (s.force_N) sum += *s.force_N, ++n;
    const Maybe peak = s.peak_N ? s.peak_N : s.force_N;
    if (!peak || (f.peak_N && *peak <= *f.peak_N)) continue;
    f.peak_N = peak;
    f.x_mm = f.y_mm = Maybe();
    if (i < m.also.stitches.x_mm.size() && std::isfinite(m.also.stitches.x_mm[i]))
      f.x_mm = m.also.stitches.x_mm[i], f.y_mm = m.also.stitches.y_mm[i];
  }
  if (n > 0) f.mean_N = sum / n, f.closure_N = m.result.metric("closure_force_N");
  return f;
}

std::vector<ClassColumn> class_columns(const std::vector<ClassRow>& rows) {
  Columns c{rows, {}};
  c.add("name", "", "pseudonym of the recording's content; with --names its file",
        [](const ClassRow& r) { return r.member.name; });
  c.add("expert", "", "1: the expert, 0: a student", [](const ClassRow& r) { return r.expert ? "1" : "0"; });
  c.add("kind", "", "what was measured: recording, script, result",
        [](const ClassRow& r) { return r.member.also.kind; });
  c.add("whole", "", "1: the session ended, 0: it was cut short; empty: not known", [](const ClassRow& r) {
    return r.member.also.whole ? std::string(*r.member.also.whole ? "1" : "0") : std::string();
  });
  c.add("total_s", "s", "length of the session",
        [](const ClassRow& r) { return text_of(exercise_of(r.member.result, "time_s")); });
  // The steps of the plan are those of every row.
  const std::vector<StepWalk> steps = rows.empty() ? std::vector<StepWalk>() : rows.front().walk.steps;
  for (size_t i = 0; i < steps.size(); ++i) {
    const std::string before = fmt::format("step_{}_{}", i + 1, column_name(steps[i].name));
    const auto of = [i](const ClassRow& r) { return i < r.walk.steps.size() ? &r.walk.steps[i] : nullptr; };
    c.add(before + "_s", "s", "time that led to acts of the step \"" + steps[i].name + "\"", [of](const ClassRow& r) {
      const StepWalk* s = of(r);
      return s ? text_of(s->time_s) : std::string();
    });
    c.add(before + "_done", "", "its acts that were done, of " + std::to_string(steps[i].planned),
          [of](const ClassRow& r) {
            const StepWalk* s = of(r);
            return s ? std::to_string(s->done) : std::string();
          });
    c.add(before + "_off", "", "the worst that is off, as a share of what may be off; above 1: off",
          [of](const ClassRow& r) {
            const StepWalk* s = of(r);
            return s && s->done > s->shown ? text_of(Maybe(s->share)) : std::string();
          });
  }
  if (!steps.empty()) {
    c.add("elsewhere_s", "s", "time that led to acts that the plan does not have",
          [](const ClassRow& r) { return text_of(r.walk.elsewhere_s); });
    c.add("taken_back_s", "s", "time that led to undo and redo",
          [](const ClassRow& r) { return text_of(r.walk.taken_back_s); });
    c.add("afterwards_s", "s", "time after the last act",
          [](const ClassRow& r) { return text_of(r.walk.afterwards_s); });
    c.add("out_of_order", "", "acts that came while one of an earlier step was open",
          [](const ClassRow& r) { return std::to_string(r.walk.out_of_order); });
    c.add("elsewhere", "", "acts that stand at the end and are of no plan",
          [](const ClassRow& r) { return std::to_string(r.walk.elsewhere); });
    c.add("shown", "", "acts that stand and were shown by the program",
          [](const ClassRow& r) { return std::to_string(r.walk.shown); });
  }
  c.add_exercise("path_mm", "mm", "way of the hand while it was tracked");
  c.add_exercise("movements", "", "movements of the hand (limberg measures)");
  c.add_exercise("pressed_s", "s", "time with the tool pressed");
  c.add("missed_presses", "", "presses that came to nothing, and gestures that were no act", [](const ClassRow& r) {
    const ResultDevice& d = r.member.result.device;
    return d.missed_presses ? text_of(MaybeCount(*d.missed_presses + d.dropped_gestures.value_or(0))) : std::string();
  });
  c.add_exercise("refused", "", "acts that the patient refused");
  c.add_exercise("undos", "", "acts taken back");
  c.add_exercise("cuts", "", "incisions, excisions and underminings");
  c.add_exercise("hooks", "", "hooks set");
  c.add_exercise("stitches", "", "stitches at the end");
  c.add("force_peak_N", "N", "largest force of a stitch in any state at rest",
        [](const ClassRow& r) { return text_of(forces_of(r.member).peak_N); });
  c.add("force_peak_x_mm", "mm", "where that stitch lies, on the skin at rest",
        [](const ClassRow& r) { return text_of(forces_of(r.member).x_mm); });
  c.add("force_peak_y_mm", "mm", "the same", [](const ClassRow& r) { return text_of(forces_of(r.member).y_mm); });
  c.add("force_mean_N", "N", "mean force of the stitches at the end",
        [](const ClassRow& r) { return text_of(forces_of(r.member).mean_N); });
  c.add("closure_force_N", "N", "sum of the forces of the stitches at the end",
        [](const ClassRow& r) { return text_of(forces_of(r.member).closure_N); });
  c.add_metric("hook_force_N", "N", "of hooks that are still held at the end, magnitudes together");
  c.add_metric("wound_gape_mm", "mm", "gape of the wound's edge, 95 % of it");
  c.add_metric("dog_ear_mm", "mm", "height of the largest dog-ear");
  c.add_metric("stretch_p99", "", "stretch of the skin, 99 % of it");
  c.add_metric("inverted_cells", "", "cells of tissue that are inside out");
  c.add("residual", "", "relative residual at the end; at rest below 1e-4",
        [](const ClassRow& r) { return text_of(r.member.result.residual); });
  std::vector<std::string> tolerances;
  for (const ClassRow& r : rows)
    for (const ResultTolerance& t : entries(r.member.result.lesson.tolerances))
      if (std::find(tolerances.begin(), tolerances.end(), t.name) == tolerances.end()) tolerances.push_back(t.name);
  for (const std::string& name : tolerances) {
    std::string unit, limit;
    const auto of = [name](const ClassRow& r) -> const ResultTolerance* {
      for (const ResultTolerance& t : entries(r.member.result.lesson.tolerances))
        if (t.name == name) return &t;
      return nullptr;
    };
    for (const ClassRow& r : rows)
      if (const ResultTolerance* t = of(r); t && limit.empty()) unit = t->unit, limit = text_of(t->limit);
    const std::string words = words_of_tolerance(name) + ", of the lesson: at most " + limit;
    c.add("lesson_" + name, unit, words, [of](const ClassRow& r) {
      const ResultTolerance* t = of(r);
      return t ? text_of(t->value) : std::string();
    });
    c.add("lesson_" + name + "_met", "", "1: met, 0: not met, or it could not be measured", [of](const ClassRow& r) {
      const ResultTolerance* t = of(r);
      return t ? std::string(t->met ? "1" : "0") : std::string();
    });
  }
  return c.all;
}

std::string csv_field(const std::string& text) {
  // A spreadsheet would take a name that begins so for a formula.
  const std::string plain =
      !text.empty() && std::string_view("=@+\t\r").find(text[0]) != std::string_view::npos ? "'" + text : text;
  if (plain.find_first_of(",\"\r\n") == std::string::npos) return plain;
  std::string s = "\"";
  for (const char ch : plain) s += ch == '"' ? std::string("\"\"") : std::string(1, ch);
  return s + "\"";
}

std::string csv_of(const std::vector<ClassColumn>& columns) {
  std::string s;
  for (size_t k = 0; k < columns.size(); ++k) s += (k ? "," : "") + csv_field(columns[k].name);
  s += "\n";
  for (size_t i = 0; !columns.empty() && i < columns[0].value.size(); ++i) {
    for (size_t k = 0; k < columns.size(); ++k) s += (k ? "," : "") + csv_field(columns[k].value[i]);
    s += "\n";
  }
  return s;
}

std::string csv_of_meanings(const std::vector<ClassColumn>& columns) {
  std::string s = "column,unit,meaning\n";
  for (const ClassColumn& c : columns)
    s += csv_field(c.name) + "," + csv_field(c.unit) + "," + csv_field(c.meaning) + "\n";
  return s;
}

}  // namespace limberg
