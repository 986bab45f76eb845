#pragma once
// What the hands are and hold, as far as a picture needs to know it.
#include <array>

#include "sim/geometry/vec.h"

namespace limberg {

/// The hand of a glove.
struct GlovePose {
  bool visible = false;
  bool closed = false, holds = false;
  bool left = false;    // a left hand
  bool whole = true;    // palm and all fingers; else the last joints of thumb and forefinger, which hide little
  bool points = false;  // at pointed_mm; of a hand that holds something: where it holds it
  Vec3f forefinger_mm = Vec3f::Zero(), thumb_mm = Vec3f::Zero();  // the finger tips
  Vec3f pointing = Vec3f::UnitX();                                // the forefinger's direction, unit
  Vec3f pointed_mm = Vec3f::Zero();
  Vec3f thumbwards = Vec3f::Zero();  // unit, across the forefinger towards the thumb; zero: not known but by the tips
};

struct ToolPose {
  enum class Kind { stylus, scalpel, hook, needle_holder, dissector, scissors, marker, swab, saw };
  bool visible = false;
  Kind kind = Kind::stylus;
  Vec3f tip_mm = Vec3f::Zero();
  Vec3f shaft = Vec3f::UnitZ();  // unit, from the tip towards the hand
  int bites = 0;                 // of a stitch that is begun: the thread runs through the last of them to the needle
  std::array<Vec3f, 2> bite_mm{Vec3f::Zero(), Vec3f::Zero()};
  bool closed = false;           // scissors
  GlovePose glove, other_glove;  // other hands
};

}  // namespace limberg
