#include "devices/glove_hand.h"

#include <cmath>

namespace limberg {

namespace {

Calibration with_glove(const Calibration& c, const GloveParameters& glove) {
  Calibration k = c;
  k.glove = glove;
  return k;
}

}  // namespace

GloveHand::GloveHand(const Calibration& c, const GloveParameters& glove, int32_t number)
    : tracker_(with_glove(c, glove)), virtual_(glove, number) {}

void GloveHand::add(StationRole as, TrackerSample reading) {
  seen_ = true;
  reading.role = as;
  tracker_.add(reading);
}

void GloveHand::set_gain(double gain) {
  reset_gain_ = !(gain > 0);
  if (gain > 0) gain_.set(gain);
}

bool GloveHand::free() const {
  const SecondHand& h = virtual_.state();
  // A glove that is gone presses nothing.
  return !(hand_.closed && hand_.valid) && h.held_hook == 0 && h.carried.holds == 0;
}

void GloveHand::read(int64_t now_ns) {
  if (!seen_) return;
  if (reset_gain_ && free()) gain_.reset(), reset_gain_ = false;
  was_closed_ = hand_.closed;
  hand_ = gain_.at(tracker_.at(now_ns));
}

Pose GloveHand::push_cursor(const Snapshot& s, Ground ground, bool clutch) {
  opening_.tick(hand_);
  if (s.topology && !s.topology->body) ground = Ground::bone;  // as where a hand points (virtual_hand.h)
  cursor_.set_ground(ground);
  Pose finger = hand_.forefinger;
  finger.valid = hand_.valid;
  if (!cursor_.placed() && hand_.valid) {
    PointingSearch ray;
    ray.ground = ground;
    const PointedPlace p = ray.find(s, hand_.forefinger.tip_mm, hand_.pointing);
    if (p.triangle >= 0)
      cursor_.put(s, SurfacePlace{p.triangle, p.bary});
    else
      cursor_.put(s, hand_.forefinger.tip_mm);
  }
  const bool bends = std::abs(opening_.mm_s()) > OpeningRate::kClosing_mm_s;
  cursor_.tick(s, finger, clutch || bends, hand_.closed);
  Pose tool = finger;
  tool.valid = hand_.valid && cursor_.placed();
  tool.tip_mm = cursor_.x_mm(), tool.shaft = -hand_.pointing, tool.orientation = hand_.orientation;
  return tool;
}

void GloveHand::act(int64_t tick, bool has_tool, bool clutch, const Snapshot& s, EventSink& out, Ground ground) {
  if (!seen_) return;
  if (has_tool)
    virtual_.show_at_cursor(hand_, cursor_.placed(), cursor_.x_mm());
  else
    virtual_.tick(tick, hand_, clutch, s, out, ground);
}

}  // namespace limberg
