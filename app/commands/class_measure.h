#pragma once
// What `limberg class` measures: a recording done again on its own clock, or a script carried out, seen while it goes
// on and looked at at its end. What comes of it is the text of a result with `class` in it (app/class/member.h).
#include <functional>
#include <optional>
#include <string>

#include "app/assembly/lesson.h"
#include "app/class/gather.h"
#include "app/class/member.h"

namespace limberg {

struct ClassMeasure {
  const Lesson* lesson = nullptr;  // null: nothing is judged
  double cell_mm = 0;              // of all; 0: as recorded
  std::string scene;               // of a script that names none
  int workers = 1;
  std::string picture;  // where the picture of the result goes
  std::function<void(double done, double total, const char* unit)> progress;
};

/// Nothing: interrupted. InputError: it cannot be done again, or the lesson is not about its scene.
std::optional<std::string> measured(const FoundSession& session, const ClassMeasure& how);

/// A session's folder has been measured already: where it was judged by another lesson or by none, by this one, as far
/// as its figures go.
void judge_by(ClassMember& member, const Lesson& lesson);

}  // namespace limberg
