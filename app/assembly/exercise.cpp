#include "app/assembly/exercise.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "app/result/schema.h"
#include "sim/commands/strokes.h"

namespace limberg {

Exercise exercise(std::span<const Command> script, const Metrics& m, const std::optional<PlanOnSkin>& plan) {
  Exercise e;
  for (const Command& c : join_strokes(script)) {
    e.cuts +=
        std::holds_alternative<Incise>(c) || std::holds_alternative<Excise>(c) || std::holds_alternative<Undermine>(c);
    e.hooks += std::holds_alternative<SetHook>(c);
    e.hook_moves += std::holds_alternative<MoveHook>(c);
    e.threads_cut += std::holds_alternative<CutSuture>(c);
    e.undos += std::holds_alternative<Undo>(c);
    e.redos += std::holds_alternative<Redo>(c);
  }
  e.stitches = int(m.sutures.size());
  for (const SutureFigure& s : m.sutures) {
    e.gaps_open += s.gap_mm > 0.2;
    e.peaks_over_2_5_N += s.peak_N > 2.5;
    e.peaks_over_5_N += s.peak_N > 5;
  }
  if (plan) e.design = design_error(*plan, script);
  return e;
}

std::vector<Judgement> fill_exercise(Result& r, const Exercise& e, const Metrics& m, const Lesson* lesson) {
  LessonValues measured = lesson_values(m, e.design);
  std::map<std::string, double>& values = measured.value;
  values["undos"] = e.undos;
  const auto set = [&](const char* name, auto v) { r.set(std::string("/exercise/") + name, v); };
  if (e.time_s) set("time_s", *e.time_s), values["time_s"] = *e.time_s;
  if (e.hand) {
    set("path_mm", e.hand->path_mm);
    set("movements", e.hand->movements);
    set("tracked_s", e.hand->tracked_s);
    set("pressed_s", e.hand->pressed_s);
    set("tracking_gaps", e.hand->gaps);
    set("tracking_lost_s", e.hand->lost_s);
    values["path_mm"] = e.hand->path_mm;
    values["movements"] = e.hand->movements;
  }
  set("cuts", e.cuts), set("hooks", e.hooks), set("hook_moves", e.hook_moves), set("stitches", e.stitches);
  set("threads_cut", e.threads_cut), set("undos", e.undos), set("redos", e.redos), set("refused", e.refused);
  set("gaps_open", e.gaps_open), set("peaks_over_2_5_N", e.peaks_over_2_5_N), set("peaks_over_5_N", e.peaks_over_5_N);
  if (e.design) {
    set("design/corner_mean_mm", e.design->corner_mean_mm);
    set("design/corner_max_mm", e.design->corner_max_mm);
    set("design/angle_max_deg", e.design->angle_max_deg);
    set("design/limb_max_percent", e.design->limb_max_percent);
    set("design/corners", e.design->corners);
    set("design/missing", int(e.design->missing.size()));
  }
  if (!lesson) return {};
  r.set("/lesson/title", lesson->title);
  r.set("/lesson/goal", lesson->goal);
  r.set("/lesson/file", lesson->file);
  bool all = true;
  auto judged = judge(*lesson, measured);
  if (!e.hand)
    std::erase_if(judged, [](const Judgement& j) {
      return !j.value && (j.name == "time_s" || j.name == "path_mm" || j.name == "movements");
    });
  for (const Judgement& x : judged) {
    append(r, "/lesson/tolerances", ResultTolerance{x.name, x.unit, x.limit, x.value, x.met, x.value ? "" : x.why});
    all &= x.met;
  }
  r.set("/lesson/all_met", all);
  for (size_t i = 0; i < lesson->hints.size(); ++i) r.set("/lesson/hints/" + std::to_string(i), lesson->hints[i]);
  return judged;
}

void print_judgements(const std::vector<Judgement>& judged) {
  for (const Judgement& j : judged) {
    const std::string value =
        j.value ? fmt::format("{:.3g}", std::abs(*j.value) < 1e-6 ? 0 : *j.value) : std::string("-");
    fmt::print("lesson      {:<14} {:>8} of at most {:6.3g} {:<8} {}\n", j.name, value, j.limit, j.unit,
               j.met     ? "met"
               : j.value ? "missed"
                         : "not measured: " + j.why);
  }
}

}  // namespace limberg
