#pragma once
// The plan of a lesson: its steps, each with the acts of the script that lead to its stage, and the letters of the
// corners that are drawn. Nothing of it knows a patient; places are of the chart, of bone in the frame of the head.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/assembly/lesson.h"
#include "app/words/words.h"
#include "sim/commands/command.h"

namespace limberg {

/// A corner of the cuts, as the drawing on the skin names it.
struct LetteredPoint {
  char letter = 'A';
  ChartPoint at{0, 0};
};

struct PlannedAct {
  Command command;
  size_t step = 0;
  std::string words;  // what to do, by the letters
  /// Of a cut of bone, once a patient was seen: where it runs on the bone that it is meant for (saw_watch.h).
  std::vector<Vec3> on_bone_mm;
};

struct TeachingStep {
  std::string name;  // as it is shown; words.stage is that of the script
  LessonStep words;  // `say` is there even where the lesson has none: made from the acts
  size_t first = 0, acts = 0;
};

/// How far off an act may be and count as done as planned.
struct PlanLimits {
  double corner_mm = 2, angle_deg = 10, limb_percent = 10;
};

struct LessonPlan {
  std::string title, goal;
  std::vector<TeachingStep> steps;
  std::vector<PlannedAct> acts;
  std::vector<LetteredPoint> letters;
  std::vector<SafeLimit> limits;
  std::vector<std::string> hints;  // of the whole lesson
  PlanLimits within;
  std::vector<std::pair<std::string, double>> tolerances;
  bool bone = false;
  Words w;  // what all its words are in, but stages and names of tolerances
};

/// Of a script alone (`lesson` null) the steps have the names of its stages, and no reasons.
LessonPlan make_lesson_plan(const Lesson* lesson, std::span<const Command> script, const Words& words = {});

/// "D", or "between D and E", or "" where no letter is within reach.
std::string near_letter(std::span<const LetteredPoint> letters, const ChartPoint& at, const Words& words = {});
/// The letter at this place; two, in their order, of a place between them; 0: none is near.
struct NearLetters {
  char first = 0, second = 0;
};
NearLetters near_letters(std::span<const LetteredPoint> letters, const ChartPoint& at);

}  // namespace limberg
