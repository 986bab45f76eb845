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
//   because = "..."                      said after the answer, whichever it was
//   [[limit]]                            what is not to be crossed; with a line, a depth or both
//   name = "branch of the facial nerve"
//   line = [[x, y], ...]                 on the skin; or left out
//   deepest_mm = 5                       of a blade; or left out
#include <optional>
#include <string>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct LessonQuestion {
  std::string ask, because;
  std::vector<std::string> answers;
  int right = 1;  // from 1
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
};

struct LessonWords {
  std::vector<LessonStep> steps;
  std::vector<SafeLimit> limits;
};

}  // namespace limberg
