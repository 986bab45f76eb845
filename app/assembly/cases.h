#pragma once
// The library of cases: each a lesson (what to do, where, how well) with the operation that its surgeon did.
//
//   app/lessons/NAME.toml        title, goal, scene, plan, tolerances, hints
//   recordings/NAME.jsonl        the script, at any resolution
//   recordings/NAME.lcm          a recorded hand that carries it out, where there is one
#include <string>
#include <vector>

#include "app/assembly/lesson.h"

namespace limberg {

struct Case {
  std::string name;
  Lesson lesson;
  std::string script, recording;  // paths; recording: empty where there is none
};

/// All that are shipped, by name. InputError where one of their lessons cannot be read.
std::vector<Case> shipped_cases();
/// InputError that lists the names to be had.
Case open_case(const std::string& name);

}  // namespace limberg
