#include "devices/force/force_loop.h"

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/geometry/triangle.h"

namespace limberg {

namespace {
constexpr double kDeepest_mm = 25;  // further in, the tip came from elsewhere
constexpr double kLeave_mm = 1.0;   // out of a cut so far: the skin closes for the next one
}  // namespace

void ForceLoop::take(const ForceModel& m) {
  if (m.t_ns < 0 || (had_model_ && m.seq <= model_.seq)) return;
  from_N_mm_ = had_model_ ? now_N_mm_ : m.stiffness_N_mm;
  const bool same_hook = had_model_ && model_.hooked && m.hooked;
  from_hook_N_mm_ = same_hook ? now_hook_N_mm_ : 0;
  from_home_ = same_hook ? now_home_ : m.hook_home_mm;
  model_ = m;
  had_model_ = model_fresh_ = true;
}

/// The surface point that is nearest; below it is where its facet's normal points away.
bool ForceLoop::closest(const Vec3& p, Touch& best) const {
  double best2 = 1e300;
  for (int i = 0; i < model_.facets; ++i) {
    const auto& f = model_.facet[size_t(i)];
    const Vec3 n = area_vector2(f[0], f[1], f[2]);
    const double length = n.norm();
    if (!(length > 0)) continue;
    const TrianglePoint q = closest_on_triangle(p, f[0], f[1], f[2]);
    const double d2 = (p - q.point).squaredNorm(), side = (p - q.point).dot(n) / length;
    // Of facets equally near (an edge, a corner) the one that faces the tip most speaks.
    if (d2 < best2 - 1e-12 || (d2 < best2 + 1e-12 && std::abs(side) > std::abs(best.depth))) {
      best2 = std::min(best2, d2);
      best = {q.point, n / length, -side, std::sqrt(d2)};
    }
  }
  return best2 < 1e300;
}

Vec3 ForceLoop::contact_force(const Vec3& tip, double k) {
  Touch t{};
  const bool near = closest(tip, t);
  state_.plane_mm = near ? t.point : tip;
  state_.normal = near ? t.normal : Vec3(Vec3::Zero());
  if (k <= 0 || !near || t.depth <= 0 || t.depth > kDeepest_mm || t.apart > t.depth + 3) {
    if (!near || -t.depth > kLeave_mm) plastic_mm_ = 0, state_.cut = false;
    state_.touching = false;
    state_.depth_mm = 0;
    state_.proxy_mm = tip;
    return Vec3::Zero();
  }
  if (model_.puncture_N <= 0) plastic_mm_ = 0, state_.cut = false;  // what is held or met now does not cut
  state_.depth_mm = t.depth;
  // A tool in tissue is held back by what it parts, a blunt one by its friction.
  const double held_back = state_.cut || model_.drawn ? model_.draw_N + model_.draw_N_mm * t.depth : 0;
  const double along = limit_.stiffness_N_mm / 2;
  if (!state_.touching) {
    // Entered since the last tick: the proxy is where the tip went through.
    state_.touching = true;
    state_.proxy_mm = t.point;
  } else {
    // The proxy stays on the surface and sticks to it within the friction cone.
    Touch on{};
    closest(state_.proxy_mm, on);
    const Vec3 aside = on.point - t.point, slip = aside - aside.dot(t.normal) * t.normal;
    const double most = held_back > 0 ? held_back / along : model_.friction * t.depth, length = slip.norm();
    state_.proxy_mm = length > most ? Vec3(t.point + slip * (most / length)) : on.point;
  }
  // The blade: elastic up to the puncture, afterwards the skin gives way and keeps what was cut.
  double normal = k * std::max(0.0, t.depth - plastic_mm_);
  if (model_.puncture_N > 0) {
    if (!state_.cut && normal >= model_.puncture_N) state_.cut = true;
    if (state_.cut && normal > model_.cutting_N) {
      plastic_mm_ = t.depth - model_.cutting_N / k;
      normal = model_.cutting_N;
    }
  }
  const Vec3 aside = state_.proxy_mm - t.point;
  const double share = t.depth > 0 ? normal / (k * t.depth) : 0;  // of the elastic force that is left
  return normal * t.normal + (held_back > 0 ? along : share * k) * (aside - aside.dot(t.normal) * t.normal);
}

// Euler's capstan: bent at its hole from the normal to where the hand is. It slips out under what that takes, and does
// not go back.
Vec3 ForceLoop::thread_force(const Vec3& tip) {
  const Vec3 away = tip - model_.thread_from_mm;
  const double r = away.norm(), k = limit_.stiffness_N_mm / 2;
  if (!threaded_) threaded_ = true, thread_out_mm_ = r;
  if (!(r > 1e-9)) return Vec3::Zero();
  const double bend = elementary::acos(std::clamp(away.dot(model_.thread_normal) / r, -1.0, 1.0));
  const double most = model_.thread_N * elementary::exp(model_.thread_friction * bend);
  thread_out_mm_ = std::max(thread_out_mm_, r - most / k);
  return -k * std::max(0.0, r - thread_out_mm_) / r * away;
}

/// The force that was on the hand when it began to move as the newest reading says: what was asked for by then.
const Vec3& ForceLoop::force_behind(int64_t t_ns) const {
  const auto newest = uint64_t(counts_.ticks);
  for (uint64_t k = 0; k < past_.size(); ++k)
    if (const Past& p = past_[(newest - k) % past_.size()]; p.t_ns <= t_ns) return p.force_N;
  return past_[(newest + 1) % past_.size()].force_N;
}

const ForceState& ForceLoop::tick(int64_t now_ns, const Vec3& tip, bool valid) {
  ++counts_.ticks;
  const double dt = last_ns_ < 0 ? 1e-3 : std::max(1e-6, double(now_ns - last_ns_) * 1e-9);
  const double share = dt < 0.9e-3 ? dt * 1e3 : 1;  // of a whole tick
  const bool stalled = last_ns_ >= 0 && dt > limit_.stall_s;
  past_[uint64_t(counts_.ticks) % past_.size()] = {last_ns_, state_.force_N};
  const int64_t moved_from_ns = last_ns_ - int64_t(limit_.delay_s * 1e9);
  last_ns_ = now_ns;
  if (model_fresh_) model_came_ns_ = now_ns, model_fresh_ = false;
  const Vec3 before = state_.force_N, travelled = tip - last_tip_;
  last_tip_ = tip;

  if (!valid || !had_model_) {
    state_.force_N.setZero();
    state_.normal.setZero();
    state_.touching = state_.hooked = false;
    ramp_ = 0;
    held_over_.setZero();
    return state_;
  }
  // N mm = mJ: what the hand did against the force that it felt.
  state_.energy_mJ -= force_behind(moved_from_ns).dot(travelled);
  const Vec3 v = travelled / dt;
  if (stalled) {
    ++counts_.stalls;
    slow_v_ = v;
    state_.touching = false;  // where it was held on the surface is long ago
    const double period = double(model_.period_ns) * 1e-9;
    if (dt > (1 + limit_.stale_periods) * period + limit_.decay_s) {
      const double size = before.norm();
      state_.force_N = size > limit_.slew_N ? Vec3(before * (1 - limit_.slew_N / size)) : Vec3(Vec3::Zero());
      state_.energy_mJ = std::max(0.0, state_.energy_mJ);
      ramp_ = 0;
      held_over_.setZero();
      return state_;
    }
  }
  const double step_s = std::min(dt, limit_.stall_s);  // what fades does not jump over a stall

  const double w =
      std::clamp(double(now_ns - model_came_ns_) / double(std::max<int64_t>(1, model_.period_ns)), 0.0, 1.0);
  now_N_mm_ = from_N_mm_ + w * (model_.stiffness_N_mm - from_N_mm_);
  now_hook_N_mm_ = from_hook_N_mm_ + w * (model_.hook_stiffness_N_mm - from_hook_N_mm_);
  now_home_ = from_home_ + w * (model_.hook_home_mm - from_home_);
  // In series with the coupling.
  const auto coupled = [&](double k) { return k > 0 ? k * limit_.stiffness_N_mm / (k + limit_.stiffness_N_mm) : 0; };
  state_.stiffness_N_mm = coupled(model_.hooked ? now_hook_N_mm_ : now_N_mm_);
  state_.hooked = model_.hooked;
  Vec3 f = contact_force(tip, coupled(now_N_mm_));
  if (model_.thread_N > 0)
    f += thread_force(tip);
  else
    threaded_ = false;
  if (model_.hooked) f += coupled(now_hook_N_mm_) * (now_home_ - tip);
  // The encoder's steps of 0.01 mm are 10 mm/s from tick to tick: the coupling's damper acts on a smoothed speed.
  slow_v_ += 0.2 * share * (v - slow_v_);
  if (state_.touching || model_.hooked) f -= limit_.damping_N_s_mm * slow_v_;

  const bool stale =
      double(now_ns - model_.t_ns) > limit_.stale_periods * double(model_.period_ns) + double(model_.period_ns);
  counts_.stale += stale;
  fade_ = std::clamp(fade_ + (stale ? -step_s / limit_.decay_s : step_s / limit_.decay_s), 0.0, 1.0);
  ramp_ = std::min(1.0, ramp_ + step_s / limit_.ramp_s);
  f *= fade_ * ramp_;
  if (stalled)
    held_over_ = before - f;
  else
    held_over_ *= elementary::exp(-step_s / limit_.catch_up_s);
  if (!state_.touching && !model_.hooked && !threaded_) held_over_.setZero();
  f += fade_ * held_over_;

  // More would go into the hand than came out of it: a damper as strong as needed.
  if (state_.energy_mJ < -limit_.spare_mJ && v.squaredNorm() > 1e-6) {
    const double missing = -limit_.spare_mJ - state_.energy_mJ;  // mJ = N mm
    const double b = std::min(limit_.most_damping_N_s_mm, missing / (v.squaredNorm() * dt));
    f -= b * v;
    ++counts_.damped;
  }
  counts_.least_energy_mJ = std::min(counts_.least_energy_mJ, state_.energy_mJ);
  constexpr double kMost_mJ = 50;  // what was put in long ago does not pay for what comes out now
  state_.energy_mJ = std::min(state_.energy_mJ, kMost_mJ);

  if (const double size = f.norm(); size > limit_.force_N) f *= limit_.force_N / size, ++counts_.saturated;
  if (const double step = (f - before).norm(); step > share * limit_.slew_N)
    f = before + (f - before) * (share * limit_.slew_N / step), ++counts_.slewed;
  counts_.largest_step_N = std::max(counts_.largest_step_N, (f - before).norm());
  state_.force_N = f;
  return state_;
}

}  // namespace limberg
