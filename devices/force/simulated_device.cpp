#include <algorithm>
#include <cmath>

#include "devices/force/force_device.h"

namespace limberg {

SimulatedForceDevice::SimulatedForceDevice(SimulatedHand hand) : hand_(std::move(hand)) {}

ForceReading SimulatedForceDevice::read(int64_t now_ns) {
  constexpr int64_t kStepNs = 100'000;
  constexpr double kStep = kStepNs * 1e-9;
  constexpr double kMmPerM = 1000;  // N / kg is m/s^2
  if (!started_) {
    started_ = true;
    t_ns_ = now_ns;
    x_ = hand_.target(double(now_ns) * 1e-9);
  }
  for (; t_ns_ + kStepNs <= now_ns; t_ns_ += kStepNs) {
    const double t = double(t_ns_) * 1e-9;
    const Vec3 goal = hand_.target(t), goal_v = (hand_.target(t + 1e-4) - goal) / 1e-4;
    const Vec3 f = force_ + hand_.weight_N + hand_.stiffness_N_mm * (goal - x_) + hand_.damping_N_s_mm * (goal_v - v_);
    v_ += f * (kMmPerM / hand_.mass_kg * kStep);
    x_ += v_ * kStep;
  }
  ForceReading r;
  r.valid = true;
  r.tip_mm = hand_.encoder_mm > 0 ? Vec3((x_ / hand_.encoder_mm).array().round() * hand_.encoder_mm) : x_;
  r.buttons = hand_.pressed(double(now_ns) * 1e-9) ? 1 : 0;
  return r;
}

void SimulatedForceDevice::push(const Vec3& force_N) {
  const double size = force_N.norm();
  force_ = size > hand_.force_N ? Vec3(force_N * (hand_.force_N / size)) : force_N;
}

}  // namespace limberg
