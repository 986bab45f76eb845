#pragma once
// From readings at 60-120 Hz to one pose per device tick.
//
// Each position axis has a constant-velocity Kalman filter (white acceleration noise), fed with the time stamps of the
// readings and predicted to the tick; orientation has the same filter on the rotation vector from the newest estimate.
// What comes out is smoothed at the tick rate by a One-Euro filter (Casiez, Roussel, Vogel 2012: a low-pass whose
// cut-off grows with speed). Readings that jump faster than a hand can move are left out; after several in a row, or
// after a gap, the filter starts anew at the reading. Nothing allocates.
#include <cstdint>

#include "calibration/calibration.h"
#include "devices/sample.h"

namespace limberg {

struct Pose {
  Vec3 tip_mm = Vec3::Zero();
  Vec3 shaft = Vec3::UnitZ();  // unit, from the tip to the hand
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  bool valid = false;  // false before the first reading and when readings have stopped
};

struct TrackingCounts {
  int64_t used = 0;
  int64_t jumps = 0;     // readings left out by the jump gate
  int64_t restarts = 0;  // the filter began anew
  int64_t missing = 0;   // numbers missing from the sequence
  int64_t late = 0;      // readings not newer than the one before
  int64_t stale_ticks = 0;
};

/// One axis of a constant-velocity Kalman filter: state (x, v), covariance P.
struct KalmanAxis {
  double x = 0, v = 0, pxx = 0, pxv = 0, pvv = 0;
  void start(double measured, double variance, double speed_variance);
  void advance(double dt_s, double q);
  void correct(double measured, double variance);
};

/// One-Euro filter of a scalar signal sampled at a steady rate.
struct OneEuro {
  double value = 0;
  bool started = false;
  /// `speed` is an outside estimate of |d value/dt|, shared by the axes so that a path is not bent.
  double step(double raw, double speed, double dt_s, double min_cutoff_hz, double beta);
};

class StylusTracker {
 public:
  explicit StylusTracker(const Calibration& calibration);
  /// A reading as received. Times of successive readings must grow; others are counted and left out.
  void add(const StylusSample& sample);
  /// The pose at `now_ns`; call once per tick with growing times.
  Pose at(int64_t now_ns);
  /// Another device's readings follow, with numbers and times of their own; until then there is no pose.
  void begin_anew() { running_ = false, last_seq_ = -1; }
  const TrackingCounts& counts() const { return counts_; }

 private:
  void restart(const Vec3& p, const Eigen::Quaterniond& q, int64_t t_ns);

  FilterParameters f_;
  DistortionGrid distortion_;
  Vec3 tip_offset_, t_WT_;
  Eigen::Quaterniond R_WT_;
  bool running_ = false;
  int rejected_in_a_row_ = 0;
  int64_t last_seq_ = -1, t_ns_ = 0, last_tick_ns_ = -1;
  Vec3 last_p_ = Vec3::Zero();
  Eigen::Quaterniond last_q_ = Eigen::Quaterniond::Identity();
  std::array<KalmanAxis, 3> p_, w_;  // w_: rotation vector about the body axes of q_
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  std::array<OneEuro, 3> smooth_p_;
  Eigen::Quaterniond smooth_q_ = Eigen::Quaterniond::Identity();
  double smooth_speed_ = 0, smooth_turn_ = 0;
  TrackingCounts counts_;
};

}  // namespace limberg
