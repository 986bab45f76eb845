#include "app/session/hand_motion.h"

#include <cmath>

#include "sim/base/elementary.h"

namespace limberg {
namespace {

constexpr double kWindow_s = 0.1, kBegins_mm_s = 30, kEnds_mm_s = 10;

}  // namespace

void HandMotion::add(double t_s, const ToolState& tool) {
  const double dt = last_s_ < 0 ? 0 : t_s - last_s_;
  last_s_ = t_s;
  const bool valid = tool.valid != 0;
  if (!valid) {
    if (was_tracked_) figures_.lost_s += dt, figures_.gaps += tracked_;
    tracked_ = moving_ = false;
    recent_.clear();
    return;
  }
  if (tracked_) {
    figures_.tracked_s += dt;
    figures_.path_mm += elementary::hypot(tool.tip_mm[0] - tip_[0], tool.tip_mm[1] - tip_[1], tool.tip_mm[2] - tip_[2]);
    if (tool.pressed) figures_.pressed_s += dt;
  }
  for (int i = 0; i < 3; ++i) tip_[i] = tool.tip_mm[i];
  tracked_ = was_tracked_ = true;
  recent_.push_back({t_s, figures_.path_mm});
  while (recent_.size() > 2 && recent_[1].t_s <= t_s - kWindow_s) recent_.pop_front();
  const double span = t_s - recent_.front().t_s;
  if (span <= 0) return;
  const double speed = (figures_.path_mm - recent_.front().path_mm) / span;
  if (!moving_ && speed > kBegins_mm_s) moving_ = true, ++figures_.movements;
  if (moving_ && speed < kEnds_mm_s) moving_ = false;
}

}  // namespace limberg
