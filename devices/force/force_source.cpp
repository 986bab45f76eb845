#include "devices/force/force_source.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace limberg {

ForceSource::ForceSource(std::unique_ptr<ForceDevice> device, const ForceSourceSettings& settings, std::shared_ptr<StiffnessLine> line)
    : device_(std::move(device)), set_(settings), line_(std::move(line)), loop_(device_->limits()) {}

void ForceSource::look(const Snapshot& s) { seen_ = &s; }

double ForceSource::contact_stiffness(const Snapshot& s, const SkinTouch& touch) {
  const double half_space = 2 * set_.tip_radius_mm * set_.young_kPa / (1 - set_.poisson * set_.poisson) * 1e-3;  // kPa mm = mN / mm
  if (!line_) return half_space;
  // How deep the tip is below the surface as it would be without it, or lies ready to be.
  line_->ask({s.topology_version, touch.triangle, touch.bary, touch.normal, set_.tip_radius_mm, loop_.state().touching ? loop_.state().depth_mm : 0});
  const PressAnswer& told = line_->newest();
  const SurfaceView& view = s.topology->view;
  if (told.stiffness_N_mm <= 0 || told.topology_version != s.topology_version || told.triangle < 0 || size_t(told.triangle) >= view.tri.size()) return half_space;
  Vec3 there = Vec3::Zero();
  for (int32_t v : view.tri[size_t(told.triangle)]) there += s.x_mm[size_t(v)].cast<double>() / 3;
  if ((there - touch.x_mm).norm() > set_.answer_reach_mm) return half_space;
  ++answers_;
  return told.stiffness_N_mm;
}

void ForceSource::make_model(const Snapshot& s) {
  const bool surface = s.topology && s.x_mm.size() == s.topology->view.X_mm.size();
  ForceModel m;
  m.seq = model_.seq + 1;
  m.t_ns = now_ns_;
  m.period_ns = last_model_ns_ < 0 ? 16'000'000 : std::clamp<int64_t>(now_ns_ - last_model_ns_, 2'000'000, 100'000'000);
  last_model_ns_ = now_ns_;
  if (surface) {
    if (!index_.built_for(s)) index_.build(*s.topology), near_ = -1;
    const SkinTouch touch = index_.closest(s, tip_, near_ >= 0 && s.step % 8 != 0 ? near_ : -1);
    near_ = touch.triangle;
    if (touch.triangle >= 0 && touch.distance_mm < set_.patch_mm) {
      m.facets = index_.facets_around(s, touch, set_.patch_mm, m.facet);
      m.stiffness_N_mm = contact_stiffness(s, touch);
    }
  }
  if (set_.cuts) m.puncture_N = set_.puncture_N, m.cutting_N = set_.cutting_N;
  // The hook that is held: the one whose handle is at the tip while the button is down.
  const HookState* held = nullptr;
  double best = set_.hook_reach_mm;
  for (const HookState& h : s.hooks) {
    const double d = (h.handle_mm.cast<double>() - tip_).norm();
    if (pressed_ && (h.id == hook_ || d < best)) {
      held = &h;
      if (h.id == hook_) break;
      best = d;
    }
  }
  if (held) {
    if (held->id != hook_) hook_ = held->id, hook_home_ = held->at_mm.cast<double>();
    const double pulled = (held->handle_mm.cast<double>() - hook_home_).norm(), force = held->force_N.cast<double>().norm();
    m.hooked = true;
    m.hook_home_mm = hook_home_;
    // Too little pull says nothing about stiffness: what was known stays.
    m.hook_stiffness_N_mm = pulled > 0.5 ? force / pulled : model_.hook_stiffness_N_mm;
    m.facets = 0;  // the tip is in the tissue that it holds
  } else {
    hook_ = 0;
  }
  model_ = m;
}

void ForceSource::poll(int64_t now_ns, SampleSink& sink) {
  now_ns_ = now_ns;
  const ForceReading r = device_->read(now_ns);
  tip_ = r.tip_mm;
  pressed_ = r.buttons & 1;
  if (seen_ && seen_->step != step_) {
    step_ = seen_->step;
    make_model(*seen_);
    loop_.take(model_);
  }
  device_->push(loop_.tick(now_ns, r.tip_mm, r.valid).force_N);
  seen_ = nullptr;
  if (!r.valid) return;
  StylusSample s;
  s.device_id = set_.device_id;
  s.seq = seq_++;
  s.t_ns = now_ns;
  s.tip_mm = r.tip_mm;
  s.quat = r.quat;
  s.buttons = r.buttons;
  sink.on_sample(s);
}

std::string ForceSource::health() const {
  const ForceCounts& c = loop_.counts();
  char text[320];
  std::snprintf(text, sizeof text, "%s, force %.2f N, %lld ticks, stiffness %.3f N/mm (%lld models from the solver), %lld saturated, %lld slewed, %lld with an old model, %lld stalls, least energy %.2f mJ", device_->name(),
                loop_.state().force_N.norm(), (long long)c.ticks, model_.stiffness_N_mm, (long long)answers_, (long long)c.saturated, (long long)c.slewed, (long long)c.stale, (long long)c.stalls, c.least_energy_mJ);
  return text;
}

}  // namespace limberg
