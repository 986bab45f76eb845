#include "tests/bench/devices/z_width.h"

#include <algorithm>
#include <cmath>

namespace limberg::bench {

FaultyDevice::FaultyDevice(const SimulatedHand& hand, const LinkFaults& faults)
    : faults_(faults), device_(exact(hand)), dice_(faults.seed) {}

ForceReading FaultyDevice::read(int64_t now_ns) {
  ForceReading r = device_.read(now_ns);
  if (faults_.encoder_mm > 0) r.tip_mm = (r.tip_mm / faults_.encoder_mm).array().round() * faults_.encoder_mm;
  readings_.push_back(r);
  const size_t late = size_t(faults_.reading_late);
  const ForceReading& now = readings_[readings_.size() > late ? readings_.size() - 1 - late : 0];
  dice_ = dice_ * 6364136223846793005ull + 1442695040888963407ull;
  if (losing_ == 0 && double(dice_ >> 11) * 0x1p-53 < faults_.lost) losing_ = faults_.lost_for;
  if (losing_ > 0 && tick_ > 0)
    --losing_;
  else
    last_ = now;
  ++tick_;
  return last_;
}

void FaultyDevice::push(const Vec3& force_N) {
  forces_.push_back(force_N);
  const size_t late = size_t(faults_.force_late);
  applied_ = forces_.size() > late ? forces_[forces_.size() - 1 - late] : Vec3(Vec3::Zero());
  device_.push(applied_);
}

WallFigures wall_trial(const WallTrial& trial) {
  SimulatedHand hand;
  hand.mass_kg = trial.mass_kg, hand.damping_N_s_mm = trial.device_damping_N_s_mm;
  hand.force_N = 1e6;
  hand.stiffness_N_mm = 0, hand.weight_N = Vec3(0, 0, -trial.press_N);
  hand.target = [](double) { return Vec3(0, 0, 1); };  // where it is let go
  FaultyDevice device(hand, trial.faults);
  ForceLimits limits;
  limits.stiffness_N_mm = 1e9;  // the wall itself is under test
  limits.damping_N_s_mm = trial.damping_N_s_mm;
  limits.force_N = 1e6, limits.slew_N = 1e6, limits.ramp_s = 1e-6;
  if (!trial.passivity) limits.spare_mJ = 1e12;
  if (trial.told_delay) limits.delay_s = (trial.faults.reading_late + trial.faults.force_late) * 1e-3;
  ForceLoop loop(limits);
  ForceModel wall;
  wall.facets = 2;
  wall.facet[0] = {Vec3(-100, -100, 0), Vec3(100, -100, 0), Vec3(100, 100, 0)};
  wall.facet[1] = {Vec3(-100, -100, 0), Vec3(100, 100, 0), Vec3(-100, 100, 0)};
  wall.stiffness_N_mm = trial.wall_N_mm, wall.friction = 0;
  WallFigures f;
  double energy = 0, squares[3] = {};
  int count[3] = {};
  Vec3 x = Vec3::Zero();
  const int ticks = int(trial.seconds * 1000);
  for (int tick = 0; tick < ticks; ++tick) {
    const int64_t t = int64_t(tick) * 1'000'000;
    if (tick % 16 == 0) ++wall.seq, wall.t_ns = t, loop.take(wall);
    const ForceReading r = device.read(t);
    const Vec3 now = device.device().true_mm();
    if (tick > 0) energy -= device.applied_N().dot(now - x);
    x = now;
    f.least_energy_mJ = std::min(f.least_energy_mJ, energy);
    const int third = std::min(2, 3 * tick / ticks);
    squares[third] += device.device().velocity_mm_s().squaredNorm(), ++count[third];
    device.push(loop.tick(t, r.tip_mm, r.valid).force_N);
    if (!(x.norm() < 1e4)) return f.tremble_mm_s = 1e9, f;  // thrown off
  }
  f.first_mm_s = std::sqrt(squares[0] / count[0]), f.before_mm_s = std::sqrt(squares[1] / count[1]),
  f.tremble_mm_s = std::sqrt(squares[2] / count[2]);
  f.damped = loop.counts().damped;
  f.stable = f.tremble_mm_s < std::max(0.5, 0.5 * trial.faults.encoder_mm * 1e3) ||
             (f.tremble_mm_s < 0.97 * f.before_mm_s && f.before_mm_s < 0.97 * f.first_mm_s);
  return f;
}

double stiffness_held(WallTrial trial, double most) {
  constexpr double kStep = 1.08;
  double held = 0;
  for (double k = 0.05; k < most; k *= kStep) {
    trial.wall_N_mm = k;
    if (!wall_trial(trial).stable) break;
    held = k;
  }
  return held;
}

}  // namespace limberg::bench
