#pragma once
// What an exercise is judged by: how long, how far, how often, how hard, how near
// to the plan. Figures, no grade: there is no published scale that turns them into
// one. The evidence is the session's script, which stands in the same result.
//
// Which figures: validation studies of surgical simulators ask for time, path length
// and number of movements (Datta et al. 2001), and for errors of the procedure beside
// them, since time and motion alone do not tell novices from experts (Rogers-Vizena
// et al. 2022, cleft lip). Thresholds of force: 2.5 N (Larrabee, Holloway and Sutton
// 1984) and 5 N (between the knot-pull strengths of USP 5-0 and 4-0).
#include <optional>
#include <span>

#include "app/assembly/lesson.h"
#include "app/result/result.h"
#include "app/session/hand_motion.h"
#include "sim/measure/metrics.h"

namespace limberg {

struct Exercise {
  std::optional<double> time_s;  // of the session; nothing for a script
  std::optional<HandFigures> hand;
  int osteotomies = 0, bone_moves = 0;  // of bones
  int cuts = 0, hooks = 0, hook_moves = 0, stitches = 0, threads_cut = 0, undos = 0, redos = 0, refused = 0;
  int gaps_open = 0;                             // stitches whose edges are more than 0.2 mm apart at the end
  int peaks_over_2_5_N = 0, peaks_over_5_N = 0;  // stitches whose force at rest was ever above
  std::vector<Command> script;                   // what was carried out
  std::optional<DesignError> design;             // against the lesson's plan, or that which the script names
};

/// `script`: what was carried out.
Exercise exercise(std::span<const Command> script, const Metrics& metrics, const std::optional<PlanOnSkin>& plan);
/// `exercise`, and with a lesson `lesson`: goal, tolerances with value and whether each is met, hints. Returns the
/// judgements. What hangs on acts that the program has shown is not judged (withhold_shown). Tolerances of the hand
/// (time, path, movements) are left out where a script was carried out without one. `measured`: of skin
/// (lesson_values) or bones (bone_values).
std::vector<Judgement> fill_exercise(Result& result, const Exercise& e, LessonValues measured, const Lesson* lesson);
/// On the terminal: one line for each, "met", "missed" or "not measured" and why.
void print_judgements(const std::vector<Judgement>& judged);

}  // namespace limberg
