#include "devices/tracking.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/elementary.h"

namespace limberg {

namespace {

using Quat = Eigen::Quaterniond;

constexpr double kNs = 1e-9;
constexpr double kStartSpeedVariance = 100.0 * 100.0;  // (mm/s)^2: a hand that comes into view moves about so
constexpr double kStartTurnVariance = 2.0 * 2.0;       // (rad/s)^2
constexpr int kRejectedBeforeRestart = 3;

/// Rotation vector of q (q and -q are the same rotation; the short way round is taken).
Vec3 log_of(Quat q) {
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double s = q.vec().norm();
  if (s < 1e-12) return 2 * q.vec();
  return q.vec() * (2 * elementary::atan2(s, q.w()) / s);
}

Quat exp_of(const Vec3& w) {
  const double a = w.norm();
  if (a < 1e-12) return Quat(1, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z()).normalized();
  const Vec3 v = w * (elementary::sin(a / 2) / a);
  return Quat(elementary::cos(a / 2), v.x(), v.y(), v.z());
}

/// Weight of the new value in a first-order low-pass (Casiez 2012, eq. 2-5).
double low_pass_weight(double dt_s, double cutoff_hz) {
  const double r = 2 * std::numbers::pi * cutoff_hz * dt_s;
  return r / (r + 1);
}

}  // namespace

void KalmanAxis::start(double measured, double variance, double speed_variance) {
  x = measured;
  v = 0;
  pxx = variance;
  pxv = 0;
  pvv = speed_variance;
}

/// White acceleration of spectral density q: Q = q [dt^3/3, dt^2/2; dt^2/2, dt].
void KalmanAxis::advance(double dt, double q) {
  x += v * dt;
  pxx += 2 * dt * pxv + dt * dt * pvv + q * dt * dt * dt / 3;
  pxv += dt * pvv + q * dt * dt / 2;
  pvv += q * dt;
}

void KalmanAxis::correct(double measured, double variance) {
  const double s = pxx + variance, kx = pxx / s, kv = pxv / s, r = measured - x;
  x += kx * r;
  v += kv * r;
  pvv -= kv * pxv;
  pxv -= kx * pxv;
  pxx -= kx * pxx;
}

double OneEuro::step(double raw, double speed, double dt_s, double min_cutoff_hz, double beta) {
  if (!started) {
    started = true;
    return value = raw;
  }
  return value += low_pass_weight(dt_s, min_cutoff_hz + beta * speed) * (raw - value);
}

StylusTracker::StylusTracker(const Calibration& c)
    : f_(c.filter),
      distortion_(c.distortion),
      tip_offset_(c.tip_offset_mm),
      t_WT_(c.world_from_tracker_mm),
      R_WT_(Quat(c.world_from_tracker_quat[0], c.world_from_tracker_quat[1], c.world_from_tracker_quat[2],
                 c.world_from_tracker_quat[3])
                .normalized()) {}

void StylusTracker::restart(const Vec3& p, const Quat& q, int64_t t_ns) {
  const double r = f_.measurement_noise_mm * f_.measurement_noise_mm;
  const double rw = f_.turn_measurement_noise_rad * f_.turn_measurement_noise_rad;
  for (size_t i = 0; i < 3; ++i) {
    p_[i].start(p[int(i)], r, kStartSpeedVariance);
    w_[i].start(0, rw, kStartTurnVariance);
    smooth_p_[i] = {};
  }
  q_ = smooth_q_ = last_q_ = q;
  last_p_ = p;
  smooth_speed_ = smooth_turn_ = 0;
  t_ns_ = t_ns;
  rejected_in_a_row_ = 0;
  if (running_) ++counts_.restarts;
  running_ = true;
}

void StylusTracker::add(const StylusSample& s) {
  const int64_t t_ns = s.t_ns - int64_t(f_.latency_ms * 1e6);
  if (last_seq_ >= 0 && (s.seq <= last_seq_ || (running_ && t_ns <= t_ns_))) {
    ++counts_.late;
    return;
  }
  if (last_seq_ >= 0) counts_.missing += s.seq - last_seq_ - 1;
  last_seq_ = s.seq;

  const Quat R_TS = Quat(s.quat[0], s.quat[1], s.quat[2], s.quat[3]).normalized();
  const Vec3 sensor = distortion_.empty() ? s.tip_mm : Vec3(s.tip_mm + distortion_.at(s.tip_mm));
  const Vec3 p = R_WT_ * (sensor + R_TS * tip_offset_) + t_WT_;
  const Quat q = (R_WT_ * R_TS).normalized();

  const double dt = double(t_ns - t_ns_) * kNs;
  if (!running_ || dt * 1e3 > f_.stale_ms) return restart(p, q, t_ns);

  // A hand moves and turns only so fast. The turn's limit is stated for readings at 120 Hz and grows with the gap.
  const double limit_deg = f_.max_turn_deg * std::max(1.0, dt * 120);
  if ((p - last_p_).norm() > f_.max_speed_mm_s * dt ||
      log_of(last_q_.conjugate() * q).norm() * 180 / std::numbers::pi > limit_deg) {
    ++counts_.jumps;
    if (++rejected_in_a_row_ > kRejectedBeforeRestart) restart(p, q, t_ns);
    return;
  }
  rejected_in_a_row_ = 0;
  last_p_ = p;
  last_q_ = q;

  const double r = f_.measurement_noise_mm * f_.measurement_noise_mm;
  const double rw = f_.turn_measurement_noise_rad * f_.turn_measurement_noise_rad;
  for (size_t i = 0; i < 3; ++i) {
    p_[i].advance(dt, f_.process_noise_mm2_s3);
    p_[i].correct(p[int(i)], r);
    w_[i].advance(dt, f_.turn_process_noise_rad2_s3);
  }
  const Vec3 seen = log_of(q_.conjugate() * q);
  for (size_t i = 0; i < 3; ++i) w_[i].correct(seen[int(i)], rw);
  // Take the rotation into the reference, so that the rotation vector stays small.
  q_ = (q_ * exp_of(Vec3(w_[0].x, w_[1].x, w_[2].x))).normalized();
  for (KalmanAxis& w : w_) w.x = 0;
  t_ns_ = t_ns;
  ++counts_.used;
}

Pose StylusTracker::at(int64_t now_ns) {
  const double dt_tick = last_tick_ns_ < 0 ? 1e-3 : std::max(1e-6, double(now_ns - last_tick_ns_) * kNs);
  last_tick_ns_ = now_ns;
  Pose pose;
  if (!running_) return pose;
  const double age = double(now_ns - t_ns_) * kNs;
  pose.valid = age * 1e3 <= f_.stale_ms;
  if (!pose.valid) ++counts_.stale_ticks;

  const double ahead = std::clamp(age, 0.0, f_.max_prediction_ms * 1e-3);
  const Vec3 v(p_[0].v, p_[1].v, p_[2].v), w(w_[0].v, w_[1].v, w_[2].v);
  const double d = low_pass_weight(dt_tick, f_.euro_derivative_cutoff_hz);
  smooth_speed_ += d * (v.norm() - smooth_speed_);
  smooth_turn_ += d * (w.norm() - smooth_turn_);
  for (size_t i = 0; i < 3; ++i)
    pose.tip_mm[int(i)] = smooth_p_[i].step(p_[i].x + p_[i].v * ahead, smooth_speed_, dt_tick, f_.euro_min_cutoff_hz,
                                            f_.euro_beta_per_mm);

  // Orientation: the same low-pass along the shortest turn. One radian per second opens it as far as 100 mm/s does a
  // position: the length of a stylus.
  constexpr double kStylusMm = 100;
  const Quat raw = q_ * exp_of(w * ahead);
  const double a = low_pass_weight(dt_tick, f_.euro_min_cutoff_hz + f_.euro_beta_per_mm * kStylusMm * smooth_turn_);
  smooth_q_ = (smooth_q_ * exp_of(a * log_of(smooth_q_.conjugate() * raw))).normalized();
  pose.orientation = smooth_q_;
  pose.shaft = smooth_q_ * Vec3::UnitZ();
  return pose;
}

}  // namespace limberg
