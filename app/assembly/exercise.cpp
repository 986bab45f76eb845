#include "app/assembly/exercise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/result/run_result.h"
#include "sim/commands/authorship.h"
#include "sim/commands/strokes.h"

namespace limberg {

Exercise exercise(std::span<const Command> script, const Metrics& m, const std::optional<PlanOnSkin>& plan) {
  Exercise e;
  e.script.assign(script.begin(), script.end());
  for (const Command& c : join_strokes(own_acts(script))) {
    e.cuts +=
        std::holds_alternative<Incise>(c) || std::holds_alternative<Excise>(c) || std::holds_alternative<Undermine>(c);
    e.hooks += std::holds_alternative<SetHook>(c);
    e.hook_moves += std::holds_alternative<MoveHook>(c);
    e.threads_cut += std::holds_alternative<CutSuture>(c);
    e.undos += std::holds_alternative<Undo>(c), e.redos += std::holds_alternative<Redo>(c);
    if (const auto* h = std::get_if<HeadCommand>(&c)) {
      e.osteotomies += std::holds_alternative<CutBone>(*h) || std::holds_alternative<CutBoneByBlade>(*h);
      e.bone_moves += std::holds_alternative<MoveFragment>(*h) || std::holds_alternative<LetGo>(*h);
    }
  }
  e.undos = std::max(0, e.undos - e.redos);  // who looks back and comes forth again has taken nothing back
  e.stitches = int(m.sutures.size());
  for (const SutureFigure& s : m.sutures) {
    e.gaps_open += s.gap_mm > 0.2;
    e.peaks_over_2_5_N += s.peak_N > 2.5;
    e.peaks_over_5_N += s.peak_N > 5;
  }
  if (plan && plan->named) e.design = design_error(*plan, script);
  return e;
}

namespace {

ResultExercise figures_of(const Exercise& e) {
  ResultExercise x;
  x.time_s = e.time_s;
  if (e.hand) {
    x.path_mm = e.hand->path_mm, x.movements = e.hand->movements;
    x.tracked_s = e.hand->tracked_s, x.pressed_s = e.hand->pressed_s;
    x.tracking_gaps = e.hand->gaps, x.tracking_lost_s = e.hand->lost_s;
  }
  if (e.osteotomies + e.bone_moves > 0) x.osteotomies = e.osteotomies, x.bone_moves = e.bone_moves;
  x.cuts = e.cuts, x.hooks = e.hooks, x.hook_moves = e.hook_moves, x.stitches = e.stitches;
  x.threads_cut = e.threads_cut, x.undos = e.undos, x.redos = e.redos, x.refused = e.refused;
  x.gaps_open = e.gaps_open, x.peaks_over_2_5_N = e.peaks_over_2_5_N, x.peaks_over_5_N = e.peaks_over_5_N;
  if (e.design)
    x.design = {e.design->corner_mean_mm,   e.design->corner_max_mm, e.design->angle_max_deg,
                e.design->limb_max_percent, e.design->corners,       e.design->missing.size()};
  return x;
}

}  // namespace

std::vector<Judgement> fill_exercise(Result& r, const Exercise& e, LessonValues measured, const Lesson* lesson) {
  write_fields(r, "/exercise", figures_of(e));
  if (!lesson) return {};
  std::map<std::string, double>& values = measured.value;
  values["undos"] = e.undos;
  if (e.time_s) values["time_s"] = *e.time_s;
  if (e.hand) values["path_mm"] = e.hand->path_mm, values["movements"] = e.hand->movements;
  auto judged = judge(*lesson, measured);
  if (!e.hand)
    std::erase_if(judged, [](const Judgement& j) {
      return !j.value && (j.name == "time_s" || j.name == "path_mm" || j.name == "movements");
    });
  withhold_shown(judged, e.script);
  const std::vector<StandingAct> standing = standing_acts(e.script);
  const auto shown = std::count_if(standing.begin(), standing.end(), [](const StandingAct& a) { return a.shown; });
  std::vector<ResultTolerance> tolerances;
  for (const Judgement& x : judged) tolerances.push_back({x.name, x.unit, x.limit, x.value, x.met, x.why});
  const bool all_met = std::all_of(judged.begin(), judged.end(), [](const Judgement& x) { return x.met; });
  write_fields(r, "/lesson",
               ResultLesson{lesson->title, lesson->goal, lesson->file, unless_empty(std::move(tolerances)), all_met,
                            unless_empty(lesson->steps), unless_empty(lesson->hints), int64_t(shown),
                            unless_empty(to_do_better(judged))});
  return judged;
}

void print_judgements(const std::vector<Judgement>& judged) {
  for (const Judgement& j : judged) {
    const std::string value =
        j.value ? fmt::format("{:.3g}", std::abs(*j.value) < 1e-6 ? 0 : *j.value) : std::string("-");
    fmt::print("lesson      {:<14} {:>8} of at most {:6.3g} {:<8} {}\n", j.name, value, j.limit, j.unit,
               j.met     ? std::string("met")
               : j.value ? "missed" + (j.why.empty() ? "" : ": " + j.why)
                         : "not measured: " + j.why);
  }
}

}  // namespace limberg
