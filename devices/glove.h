#pragma once
// Two stations on a glove, forefinger and thumb: one hand at one time.
//
// The stations are sampled one after the other, 8.3 ms apart, and each has time stamps of its own. Each is followed
// by a filter of its own (tracking.h) and predicted to the tick; only then are the two put together. Without that a
// hand that moves at 0.5 m/s along the line between its fingers would seem to open and close by 4 mm.
//
// Grab: the distance between the finger tips falls below a threshold and stays there
// for three readings, at least one of them of the other finger, so that no single wrong
// reading closes a hand; release the same way above a higher threshold. While a finger
// is not tracked neither happens: a hand out of sight keeps what it holds, and says so.
#include <cstdint>

#include "calibration/calibration.h"
#include "devices/sample.h"
#include "devices/tracking.h"

namespace limberg {

struct HandPose {
  bool valid = false;             // both fingers tracked
  Pose forefinger, thumb;         // of the finger tips
  Vec3 centre_mm = Vec3::Zero();  // between the tips
  Vec3 pointing = Vec3::UnitX();  // the forefinger's direction, unit
  /// The mean of the two sensors' orientations: fingers bend while a hand closes, the hand turns as both do together.
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  double aperture_mm = 0;
  bool closed = false;  // the hand grabs
};

struct GloveCounts {
  TrackingCounts forefinger, thumb;
  int64_t grabs = 0, releases = 0;
};

/// Open or closed, from the distance between the tips.
class GrabDetector {
 public:
  explicit GrabDetector(const GloveParameters& p);
  /// A new reading of a finger (0 forefinger, 1 thumb) with the distance that it leads to.
  void reading(double aperture_mm, int finger);
  /// Once per tick with the present distance: a threshold that is crossed back makes the count begin anew.
  void tick(double aperture_mm);
  bool closed() const { return closed_; }
  double close_below_mm() const { return low_; }

 private:
  double low_, high_;
  int needed_;
  bool closed_ = false;
  int beyond_[2] = {0, 0};  // readings beyond the threshold in a row, per finger
};

/// How fast the hand opens (mm/s, negative: it closes), smoothed over 20 ms. Once per tick.
class OpeningRate {
 public:
  static constexpr double kClosing_mm_s = 80;  // a hand that closes or opens; tremor and noise stay below 40
  void tick(const HandPose& hand);
  double mm_s() const { return rate_mm_s_; }

 private:
  bool known_ = false;
  double aperture_mm_ = 0, rate_mm_s_ = 0;
};

class GloveTracker {
 public:
  explicit GloveTracker(const Calibration& calibration);
  /// A reading of a station whose role is forefinger or thumb; others are passed over.
  void add(const TrackerSample& sample);
  HandPose at(int64_t now_ns);
  GloveCounts counts() const;

 private:
  GloveParameters g_;
  StylusTracker finger_[2];
  GrabDetector grab_;
  bool fresh_[2] = {false, false};  // readings since the last tick
  bool was_closed_ = false;
  int64_t grabs_ = 0, releases_ = 0;
};

/// A sensor reading as the tracking takes it.
StylusSample as_stylus(const TrackerSample& s);

}  // namespace limberg
