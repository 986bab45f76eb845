#include "devices/glove.h"

#include <algorithm>

namespace limberg {

namespace {

Calibration finger_calibration(const Calibration& c, const Vec3& tip_mm) {
  Calibration f = c;
  f.tip_offset_mm = tip_mm;
  return f;
}

}  // namespace

StylusSample as_stylus(const TrackerSample& t) {
  StylusSample s;
  s.device_id = t.device_id;
  s.seq = t.seq;
  s.t_ns = t.true_ns;
  s.tip_mm = t.pos_mm;
  s.quat = t.quat;
  s.buttons = t.buttons;
  return s;
}

GrabDetector::GrabDetector(const GloveParameters& p)
    : low_(p.closed_mm + p.grab_share * (p.open_mm - p.closed_mm)),
      high_(p.closed_mm + p.release_share * (p.open_mm - p.closed_mm)),
      needed_(int(p.readings)) {}

void GrabDetector::tick(double aperture_mm) {
  if (closed_ ? aperture_mm <= high_ : aperture_mm >= low_) beyond_[0] = beyond_[1] = 0;
}

void GrabDetector::reading(double aperture_mm, int finger) {
  if (closed_ ? aperture_mm <= high_ : aperture_mm >= low_) {
    beyond_[0] = beyond_[1] = 0;
    return;
  }
  ++beyond_[finger];
  const bool both = needed_ < 2 || (beyond_[0] > 0 && beyond_[1] > 0);
  if (beyond_[0] + beyond_[1] < needed_ || !both) return;
  closed_ = !closed_;
  beyond_[0] = beyond_[1] = 0;
}

void OpeningRate::tick(const HandPose& hand) {
  if (!hand.valid) {
    known_ = false, rate_mm_s_ = 0;
    return;
  }
  const double rate = known_ ? (hand.aperture_mm - aperture_mm_) * 1000 : 0;  // a tick is a millisecond
  rate_mm_s_ += 0.05 * (rate - rate_mm_s_);
  aperture_mm_ = hand.aperture_mm, known_ = true;
}

GloveTracker::GloveTracker(const Calibration& c)
    : g_(c.glove),
      finger_{StylusTracker(finger_calibration(c, c.glove.forefinger_tip_mm)),
              StylusTracker(finger_calibration(c, c.glove.thumb_tip_mm))},
      grab_(c.glove) {}

void GloveTracker::add(const TrackerSample& s) {
  const int finger = s.role == StationRole::forefinger ? 0 : s.role == StationRole::thumb ? 1 : -1;
  if (finger < 0) return;
  const int64_t used = finger_[finger].counts().used;
  finger_[finger].add(as_stylus(s));
  fresh_[finger] |= finger_[finger].counts().used != used;
}

HandPose GloveTracker::at(int64_t now_ns) {
  HandPose h;
  h.forefinger = finger_[0].at(now_ns);
  h.thumb = finger_[1].at(now_ns);
  h.valid = h.forefinger.valid && h.thumb.valid;
  if (h.valid) {
    const Vec3 apart = h.thumb.tip_mm - h.forefinger.tip_mm;
    h.aperture_mm = apart.norm();
    h.centre_mm = 0.5 * (h.forefinger.tip_mm + h.thumb.tip_mm);
    h.pointing = (h.forefinger.orientation * g_.pointing).normalized();
    // The fingers bend while they close; the hand turns as the mean of both does.
    Eigen::Quaterniond thumb = h.thumb.orientation;
    if (thumb.dot(h.forefinger.orientation) < 0) thumb.coeffs() = -thumb.coeffs();
    h.orientation.coeffs() = (h.forefinger.orientation.coeffs() + thumb.coeffs()).normalized();
    grab_.tick(h.aperture_mm);
    for (int finger = 0; finger < 2; ++finger)
      if (fresh_[finger]) grab_.reading(h.aperture_mm, finger);
  }
  fresh_[0] = fresh_[1] = false;
  h.closed = grab_.closed();
  grabs_ += h.closed && !was_closed_;
  releases_ += !h.closed && was_closed_;
  was_closed_ = h.closed;
  return h;
}

GloveCounts GloveTracker::counts() const { return {finger_[0].counts(), finger_[1].counts(), grabs_, releases_}; }

}  // namespace limberg
