#include "tests/bench/devices/force.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/operating_point/cpu_clock.h"
#include "devices/force/force_device.h"

namespace limberg::bench {

namespace {

constexpr int64_t kTickNs = 1'000'000;

/// What the solver saw, and its answer to it.
struct Answer {
  int64_t ready_ns = -1;
  double depth = 0, force = 0, tangent = 0, secant = 0;
};

}  // namespace

ForceFigures force_trial(const ForceTrial& trial) {
  SimulatedHand hand;
  constexpr double kFullTurn = 2 * std::numbers::pi;
  // Comes down, presses 5 mm deep, taps through the surface at 1.5 Hz, strokes sideways.
  hand.target = [=](double t) {
    return Vec3(4 * std::sin(kFullTurn * 0.3 * t), 0,
                10 - 13 * std::min(1.0, t / 1.0) + 4 * std::sin(kFullTurn * 1.5 * t) * (t > 2 ? 1 : 0));
  };
  SimulatedForceDevice device(hand);
  ForceLimits limits;
  limits.stiffness_N_mm = 1e6;  // the tissue itself is under test, not the coupling
  if (trial.stiffness_N_mm > 1) limits.stiffness_N_mm = 2;
  if (!trial.limits) limits.slew_N = 1e6, limits.spare_mJ = 1e9;
  ForceLoop loop(limits);
  ForceModel model;
  model.facets = 2;
  model.facet[0] = {Vec3(-100, -100, 0), Vec3(100, -100, 0), Vec3(100, 100, 0)};
  model.facet[1] = {Vec3(-100, -100, 0), Vec3(100, 100, 0), Vec3(-100, 100, 0)};
  model.friction = 0;  // what it takes away would hide what sampling gives
  model.period_ns = int64_t(1e9 / trial.solver_hz);

  ForceFigures f;
  Answer now, next;
  int64_t next_step_ns = 0;
  double energy = 0;
  Vec3 last_x = Vec3::Zero(), force = Vec3::Zero(), last_force = Vec3::Zero();
  bool first = true;
  const auto stall_tick = int64_t(trial.stall_at_s < 0 ? trial.seconds * 500 : trial.stall_at_s * 1000);
  int64_t stall_end = -1;
  const double cpu = cpu_ms();
  int64_t ticks = 0;
  for (int64_t tick = 0; tick < int64_t(trial.seconds * 1000); ++tick, ++ticks) {
    if (trial.stall_s > 0 && tick == stall_tick) {
      f.before_stall_mm_s = device.velocity_mm_s().norm();
      stall_end = tick + int64_t(trial.stall_s * 1000);
      if (trial.stalls) tick = stall_end;  // the device holds the last force meanwhile
    }
    const int64_t t = tick * kTickNs;
    const ForceReading r = device.read(t);
    const double depth = -r.tip_mm.z();
    if (t >= next_step_ns) {  // the solver begins a step with what it sees, and publishes the one before
      next_step_ns += model.period_ns;
      now = next;
      next.ready_ns = t;
      const double d = std::max(0.0, depth), k = trial.stiffness_N_mm, s = trial.stiffening;
      next.depth = depth;
      next.force = k * d * (1 + s * d);
      next.tangent = depth > 0 ? k * (1 + 2 * s * d) : 0;
      next.secant = k * (1 + s * d);
      if (now.ready_ns >= 0) {
        ++model.seq;
        model.t_ns = t;
        model.stiffness_N_mm = now.secant;
        loop.take(model);
      }
    }
    switch (trial.method) {
      case ForceMethod::local:
        force = loop.tick(t, r.tip_mm, true).force_N;
        break;
      case ForceMethod::hold:
        force = Vec3(0, 0, now.force);
        break;
      case ForceMethod::tangent:
        force = Vec3(0, 0, std::max(0.0, now.force + now.tangent * (depth - now.depth)));
        break;
    }
    if (const double size = force.norm(); size > hand.force_N) force *= hand.force_N / size;
    const Vec3 x = device.true_mm();
    if (!first) energy -= last_force.dot(x - last_x);
    if (!first) f.largest_step_N = std::max(f.largest_step_N, (force - last_force).norm());
    if (stall_end >= 0 && tick >= stall_end && tick < stall_end + 100)
      f.after_stall_mm_s = std::max(f.after_stall_mm_s, device.velocity_mm_s().norm());
    first = false;
    last_x = x;
    last_force = force;
    f.least_energy_mJ = std::min(f.least_energy_mJ, energy);
    f.force_N = std::max(f.force_N, force.norm());
    device.push(force);
  }
  f.ns_per_tick = (cpu_ms() - cpu) * 1e6 / double(std::max<int64_t>(1, ticks));
  f.damped = loop.counts().damped, f.slewed = loop.counts().slewed, f.stalls = loop.counts().stalls;
  return f;
}

StallFigures stall_trials(double stiffness_N_mm, double stall_s, int moments) {
  StallFigures out;
  for (int i = 0; i < moments; ++i) {
    ForceTrial t;
    t.stiffness_N_mm = stiffness_N_mm, t.stall_s = stall_s, t.seconds = 4;
    t.stall_at_s = 2.6 + double(i) / moments / 1.5;  // the hand taps at 1.5 Hz
    const ForceFigures f = force_trial(t);
    t.stalls = false;
    const ForceFigures calm = force_trial(t);
    t.stiffness_N_mm = 0;
    out.free_mm_s = std::max(out.free_mm_s, force_trial(t).after_stall_mm_s);
    if (f.after_stall_mm_s > out.stalled_mm_s)
      out.stalled_mm_s = f.after_stall_mm_s, out.calm_mm_s = calm.after_stall_mm_s;
    out.energy_mJ = std::min(out.energy_mJ, f.least_energy_mJ),
    out.largest_step_N = std::max(out.largest_step_N, f.largest_step_N);
  }
  return out;
}

}  // namespace limberg::bench
