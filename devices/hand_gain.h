#pragma once
// How far the hand in the scene goes when the hand in the room does: scene = at + gain (room - from), of the hand's
// centre. The hand keeps its size and its turn.
//
// A new gain counts from where the hand is: nothing jumps, and what is held goes on from its place. A hand whose gain
// was never set is where it is in the room, bit for bit.
#include "devices/glove.h"

namespace limberg {

class HandGain {
 public:
  static constexpr double kLeast = 0.05, kMost = 4;
  void set(double gain);
  /// The hand is where it is in the room again.
  void reset() { *this = {}; }
  double gain() const { return gain_; }
  /// The hand in the scene. Once per tick.
  HandPose at(const HandPose& room);

 private:
  double gain_ = 1;
  bool used_ = false, anew_ = false, known_ = false;
  Vec3 from_mm_ = Vec3::Zero(), at_mm_ = Vec3::Zero(), last_mm_ = Vec3::Zero();
};

}  // namespace limberg
