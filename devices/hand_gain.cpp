#include "devices/hand_gain.h"

#include <algorithm>

namespace limberg {

void HandGain::set(double gain) {
  gain_ = std::clamp(gain, kLeast, kMost);
  used_ = anew_ = true;
}

HandPose HandGain::at(const HandPose& room) {
  if (!room.valid) return room;
  if (!used_) {
    last_mm_ = room.centre_mm, known_ = true;
    return room;
  }
  if (anew_) from_mm_ = room.centre_mm, at_mm_ = known_ ? last_mm_ : room.centre_mm, anew_ = false;
  last_mm_ = at_mm_ + gain_ * (room.centre_mm - from_mm_), known_ = true;
  const Vec3 shift = last_mm_ - room.centre_mm;
  HandPose h = room;
  h.centre_mm = last_mm_, h.forefinger.tip_mm += shift, h.thumb.tip_mm += shift;
  return h;
}

}  // namespace limberg
