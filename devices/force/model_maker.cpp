#include "devices/force/model_maker.h"

#include <algorithm>
#include <cmath>

namespace limberg {

ForceModelMaker::ForceModelMaker(const ForceSourceSettings& settings, std::shared_ptr<StiffnessLine> line)
    : set_(settings), line_(std::move(line)) {}

void ForceModelMaker::hold(const ToolState& state) {
  if (tool_ != Tool(state.tool)) tool_ = Tool(state.tool), feel_ = feel_of(tool_, set_.puncture_N, set_.cutting_N);
  pressed_ = state.pressed != 0, held_hook_ = state.held_hook,
  shift_ = Vec3(state.shift_mm[0], state.shift_mm[1], state.shift_mm[2]);
}

double ForceModelMaker::half_space(double young_kPa, double poisson) const {
  return 2 * set_.tip_radius_mm * young_kPa / (1 - poisson * poisson) * 1e-3;  // kPa mm = mN / mm
}

SkinTouch ForceModelMaker::closest(Sheet& sheet, const Snapshot& s) {
  if (sheet.index.another(s)) sheet.near = -1;
  const SkinTouch touch = sheet.index.closest(s, tip_, sheet.near >= 0 && s.step % 8 != 0 ? sheet.near : -1);
  sheet.near = touch.triangle;
  return touch;
}

// Over skin the skin holds a blunt tip up, closed wounds included; beside it (an open wound, a bed, the block's side)
// the whole surface of the flesh counts. A blade that is in the skin stays with it. Bone only where the tip is in no
// flesh: what lies under flesh is felt through it.
ForceModelMaker::Sheet& ForceModelMaker::met(const Snapshot& s, SkinTouch& touch) {
  const auto depth = [&](const SkinTouch& t) { return t.triangle < 0 ? -1e30 : -(tip_ - t.x_mm).dot(t.normal); };
  Sheet* sheet = &skin_;
  touch = closest(skin_, s);
  double in = depth(touch);
  const double aside = touch.triangle < 0 ? 1e30 : (tip_ - touch.x_mm + in * touch.normal).norm();
  if (aside > set_.tip_radius_mm && !(cuts() && felt_.cut)) touch = closest(*(sheet = &flesh_), s), in = depth(touch);
  if (in > 0 || s.topology->organ.empty()) return *sheet;
  const SkinTouch hard = closest(bone_, s);
  if (hard.triangle < 0 || (touch.triangle >= 0 && touch.distance_mm <= hard.distance_mm)) return *sheet;
  touch = hard;
  return bone_;
}

double ForceModelMaker::contact_stiffness(const Snapshot& s, const SkinTouch& touch) {
  const double alone = half_space(set_.young_kPa, set_.poisson);
  if (!line_) return alone;
  // How deep the tip is below the surface as it would be without it, or lies ready to be.
  line_->ask({s.topology_version, touch.triangle, touch.bary, touch.normal, set_.tip_radius_mm,
              felt_.touching ? felt_.depth_mm : 0});
  const PressAnswer& told = line_->newest();
  const SurfaceView& view = s.topology->view;
  if (told.stiffness_N_mm <= 0 || told.topology_version != s.topology_version || told.triangle < 0 ||
      size_t(told.triangle) >= view.tri.size())
    return alone;
  Vec3 there = Vec3::Zero();
  for (int32_t v : view.tri[size_t(told.triangle)]) there += s.x_mm[size_t(v)].cast<double>() / 3;
  if ((there - touch.x_mm).norm() > set_.answer_reach_mm) return alone;
  ++answers_;
  return told.stiffness_N_mm;
}

const ForceModel* ForceModelMaker::make(int64_t now_ns, const Vec3& tip_mm, const ForceState& felt) {
  if (!seen_ || seen_->step == step_) return seen_ = nullptr, nullptr;
  const Snapshot& s = *seen_;
  seen_ = nullptr;
  step_ = s.step, now_ns_ = now_ns, tip_ = tip_mm, felt_ = felt;
  const bool surface = s.topology && s.x_mm.size() == s.topology->view.X_mm.size();
  ForceModel m;
  m.seq = model_.seq + 1;
  m.t_ns = now_ns_;
  m.period_ns = last_model_ns_ < 0 ? 16'000'000 : std::clamp<int64_t>(now_ns_ - last_model_ns_, 2'000'000, 100'000'000);
  last_model_ns_ = now_ns_;
  if (surface) {
    SkinTouch touch;
    const Sheet& sheet = met(s, touch);
    const bool bone = sheet.index.ground() == Ground::bone;
    if (touch.triangle >= 0 &&
        touch.distance_mm < (touch.normal.dot(tip_ - touch.x_mm) < 0 ? set_.deepest_mm : set_.patch_mm)) {
      m.facets = sheet.index.facets_around(s, touch, set_.patch_mm, m.facet);
      m.stiffness_N_mm = bone ? half_space(set_.bone_kPa, set_.bone_poisson) : contact_stiffness(s, touch);
    }
    if (!bone) {
      m.puncture_N = feel_.puncture_N, m.cutting_N = feel_.cutting_N, m.presses = feel_.presses;
      m.draw_N = feel_.draw_N, m.draw_N_mm = feel_.draw_N_mm, m.drawn = feel_.drawn_when_pressed && pressed_;
    }
    const bool thread = feel_.thread_N > 0 && pressed_;
    if (thread && !threaded_ && touch.triangle >= 0) thread_from_ = touch.x_mm, thread_normal_ = touch.normal;
    threaded_ = thread && (threaded_ || touch.triangle >= 0);
    if (threaded_) {
      m.thread_N = feel_.thread_N, m.thread_friction = feel_.thread_friction;
      m.thread_from_mm = thread_from_, m.thread_normal = thread_normal_;
    }
  }
  const HookState* held = nullptr;  // by this hand; the solver may not have set it yet
  for (const HookState& h : s.hooks)
    if (held_hook_ != 0 && h.id == held_hook_) held = &h;
  if (held) {
    if (held->id != hook_) hook_ = held->id, hook_home_ = held->at_mm.cast<double>();
    const double pulled = (held->handle_mm.cast<double>() - hook_home_).norm(),
                 force = held->force_N.cast<double>().norm();
    m.hooked = true;
    m.hook_home_mm = hook_home_ - shift_;  // behind the clutch the hand is elsewhere, and feels the same
    // Too little pull says nothing about stiffness: what was known stays.
    m.hook_stiffness_N_mm = pulled > 0.5 ? force / pulled : model_.hook_stiffness_N_mm;
    m.facets = 0;  // the tip is in the tissue that it holds
  } else {
    hook_ = 0;
  }
  model_ = m;
  return &model_;
}

}  // namespace limberg
