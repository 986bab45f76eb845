#pragma once
// What the hand holds, as far as a picture needs to know it.
#include "sim/geometry/vec.h"

namespace limberg {

struct ToolPose {
  enum class Kind { stylus, scalpel, hook, needle_holder };
  bool visible = false;
  Kind kind = Kind::stylus;
  Vec3f tip_mm = Vec3f::Zero();
  Vec3f shaft = Vec3f::UnitZ();  // unit, from the tip towards the hand
};

}  // namespace limberg
