#pragma once
// A head of one uneven shell of bone, with a landmark in front and one behind: its fragments fit in one way only.
#include "sim/skull/head/head.h"
#include "tests/sim/skull/bone/shapes.h"

namespace limberg::test {

inline HeadParts shell_head() {
  HeadParts p;
  p.bones.push_back({"cranium", skull_shell(4, {70, 85, 65}, 6, 3), true});
  p.landmarks = {{"front", {0, 60, 46}, false}, {"back", {0, -60, 46}, false}};
  return p;
}

}  // namespace limberg::test
