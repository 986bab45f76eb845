#pragma once
// What a lesson says at each step of its operation. A step is what leads to a stage of the lesson's script, and has the
// stage's name; so the acts of a step are those of the script, and a lesson only adds words.
//
//   [[step]]
//   stage = "flap cut"                   a stage of the script
//   say = "..."                          what to do, in a sentence
//   why = "..."                          the reason
//   hint = "..."                         said when one hesitates; may be left out
//   [step.question]                      asked before the step; may be left out
//   ask = "Where will it stand up?"
//   answers = ["...", "..."]             two to five
//   right = 2                            the number of the right one, from 1
//   place = [x, y]                       or, instead of answers: a place on the skin (chart, at rest) to be pointed at,
//   within = 8                           right so many mm from it
//   number = 73                          or a number to be given,
//   unit = "%"                           in this unit,
//   within = 10                          right within so much of it
//   because = "..."                      said after the answer, whichever it was
//   [[limit]]                            what is not to be crossed; with a line, a depth or both
//   name = "branch of the facial nerve"
//   line = [[x, y], ...]                 on the skin; or left out
//   deepest_mm = 5                       of a blade; or left out
//   bone_line = [[x, y, z], ...]         on bone, in the frame of the head, instead of line and depth,
//   nearest_mm = 5                       to which no saw should come nearer
#include <optional>
#include <string>
#include <vector>

#include "sim/body/chart.h"
#include "sim/geometry/vec.h"

namespace limberg {

struct LessonQuestion {
  std::string ask, because;
  std::vector<std::string> answers;
  int right = 1;  // from 1
  // Of one to be answered otherwise, whose list of answers is empty:
  std::optional<ChartPoint> place;
  std::optional<double> number;
  double within = 0;
  std::string unit;  // of the number
};
struct LessonStep {
  std::string stage, say, why, hint;
  std::optional<LessonQuestion> question;
};
/// Lines that a blade should not cross, and depths that it should not reach.
struct SafeLimit {
  std::string name;
  std::vector<ChartPoint> line;
  std::optional<double> deepest_mm;
  std::vector<Vec3> bone_line;
  double nearest_mm = 0;
};

struct LessonWords {
  std::vector<LessonStep> steps;
  std::vector<SafeLimit> limits;
};

}  // namespace limberg
