#include "devices/virtual_hand.h"

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/geometry/triangle.h"

namespace limberg {

namespace {

/// Whether a is the better place: met before beside, then nearer; beside: the smaller angle.
bool better(const PointedPlace& a, const PointedPlace& b) {
  if (b.triangle < 0) return true;
  const bool a_met = a.beside_rad == 0, b_met = b.beside_rad == 0;
  if (a_met != b_met) return a_met;
  return a_met ? a.along_mm < b.along_mm : a.beside_rad < b.beside_rad;
}

}  // namespace

void PointingSearch::slice(const Snapshot& s, size_t from, size_t to, const Vec3& origin, const Vec3& direction,
                           PointedPlace& best) const {
  const SurfaceView& view = s.topology->view;
  const double least_cos = elementary::cos(cone_rad);
  for (size_t t = from; t < to; ++t) {
    if (!s.topology->is_ground(t, ground)) continue;
    const Tri& k = view.tri[t];
    const Vec3 a = s.x_mm[size_t(k[0])].cast<double>() - origin;
    // Far beside and far away: the first corner tells, but for triangles of half the cone's width.
    const double along = a.dot(direction);
    if (along > reach_mm) continue;
    const Vec3 b = s.x_mm[size_t(k[1])].cast<double>() - origin, c = s.x_mm[size_t(k[2])].cast<double>() - origin;
    PointedPlace p;
    p.triangle = int32_t(t);
    if (const auto hit = meet_ray<Vec3>(Vec3::Zero(), direction, a, b, c); hit.met) {
      p.bary = {1 - hit.u - hit.v, hit.u, hit.v};
      p.along_mm = hit.at;
      if (hit.at <= reach_mm && better(p, best)) best = p;
      continue;
    }
    if (best.triangle >= 0 && best.beside_rad == 0) continue;
    const double length = a.norm();
    if (along < least_cos * length || length < 1e-9) continue;
    p.along_mm = along;
    p.beside_rad = std::max(1e-12, elementary::acos(std::min(1.0, along / length)));
    if (better(p, best)) best = p;
  }
}

void PointingSearch::finish(const Snapshot& s, PointedPlace& p) {
  if (p.triangle < 0) return;
  const Tri& k = s.topology->view.tri[size_t(p.triangle)];
  p.x_mm = p.X_mm = Vec3::Zero();
  for (size_t i = 0; i < 3; ++i) {
    p.x_mm += p.bary[i] * s.x_mm[size_t(k[i])].cast<double>();
    p.X_mm += p.bary[i] * s.topology->view.X_mm[size_t(k[i])];
  }
}

void PointingSearch::step(const Snapshot& s, const Vec3& origin_mm, const Vec3& direction) {
  if (!has_surface(s)) {
    found_ = best_ = {}, next_ = 0;
    return;
  }
  if (s.topology->version != version_) {
    version_ = s.topology->version;
    next_ = 0;
    found_ = {};
  }
  if (next_ == 0) origin_ = origin_mm, direction_ = direction, best_ = {};
  const size_t n = s.topology->view.tri.size(), to = std::min(n, next_ + n / kSlices + 1);
  slice(s, next_, to, origin_, direction_, best_);
  next_ = to;
  if (next_ < n) {
    finish(s, found_);  // the skin moves under what was found
    return;
  }
  next_ = 0;
  found_ = best_;
  finish(s, found_);
}

PointedPlace PointingSearch::find(const Snapshot& s, const Vec3& origin_mm, const Vec3& direction) const {
  PointedPlace p;
  if (!has_surface(s)) return p;
  slice(s, 0, s.topology->view.tri.size(), origin_mm, direction, p);
  finish(s, p);
  return p;
}

void VirtualHand::emit(ToolEvent e, EventSink& out) {
  e.hand = number_;
  if (!out.push(e)) ++lost_;
}

void VirtualHand::tick(int64_t tick, const HandPose& hand, bool clutch, const Snapshot& s, EventSink& out,
                       Ground ground) {
  search_.ground = s.topology && !s.topology->body ? Ground::bone : ground;
  opening_.tick(hand);
  state_.valid = hand.valid;
  state_.closed = hand.closed;
  if (hand.valid) {
    for (int i = 0; i < 3; ++i) state_.centre_mm[i] = hand.centre_mm[i];
    const double open = (hand.aperture_mm - glove_.closed_mm) / (glove_.open_mm - glove_.closed_mm);
    if (!hand.closed && state_.held_hook == 0 && state_.carried.holds == 0 && open >= kFrozenBelow &&
        opening_.mm_s() > -OpeningRate::kClosing_mm_s) {
      search_.step(s, hand.forefinger.tip_mm, hand.pointing);
      pointed_ = search_.place();
    }
  }
  ToolEvent e;
  e.tick = tick;
  e.snapshot = s.step;
  e.tool = int32_t(Tool::hook);
  if (hand.valid && hand.closed && !was_closed_) {
    grip_.begin(hand.centre_mm, hand.orientation, glove_.motion_scale);
    const bool there =
        pointed_.triangle >= 0 && has_surface(s) && size_t(pointed_.triangle) < s.topology->view.tri.size();
    for (int i = 0; i < 3; ++i) e.rest_mm[i] = pointed_.X_mm[i];
    if (there && s.topology->is_ground(size_t(pointed_.triangle), Ground::bone)) {
      e.kind = ToolEvent::bone_grab;
      e.tool = int32_t(Tool::grab);
      e.id = ++bone_grabs_;
      held_mm_ = pointed_.x_mm;
      state_.carried = carried(Eigen::Isometry3d::Identity(), e.id);
      ++grabs_;
      emit(e, out);
    } else if (there) {
      const ChartPoint chart = s.topology->to_chart(pointed_.X_mm);
      held_mm_ = pointed_.x_mm;
      for (const HookState& h : s.hooks)
        if (h.id / kFirstHook == number_) next_hook_ = std::max(next_hook_, h.id + 1);
      e.kind = ToolEvent::hook_set;
      e.id = state_.held_hook = next_hook_++;
      e.chart_x = chart.x(), e.chart_y = chart.y();
      for (int i = 0; i < 3; ++i) e.world_mm[i] = held_mm_[i];
      ++grabs_;
      emit(e, out);
    } else {
      ++empty_;
    }
  } else if (!hand.closed && state_.held_hook != 0) {
    e.kind = ToolEvent::hook_release;
    e.id = state_.held_hook;
    state_.held_hook = 0;
    emit(e, out);
  } else if (!hand.closed && state_.carried.holds != 0) {
    const Carried c = state_.carried;
    e.tool = int32_t(Tool::grab);
    e.id = c.holds;
    for (int i = 0; i < 3; ++i) e.world_mm[i] = c.shift_mm[i];
    for (int i = 0; i < 4; ++i) e.quat[i] = c.quat[i];
    e.kind = ToolEvent::bone_drag;
    emit(e, out);
    e.kind = ToolEvent::bone_release;
    emit(e, out);
    state_.carried = {};
  }
  if (hand.valid) {
    was_closed_ = hand.closed;
    if (hand.closed) {
      const Eigen::Isometry3d& motion = grip_.follow(hand.centre_mm, hand.orientation, clutch);
      if (state_.carried.holds != 0) state_.carried = carried(motion, state_.carried.holds);
      const Vec3 at = motion * held_mm_;
      for (int i = 0; i < 3; ++i) state_.hook_mm[i] = at[i];
    }
    const bool holds = state_.held_hook != 0 || state_.carried.holds != 0;
    state_.points = holds || (!hand.closed && pointed_.triangle >= 0);
    note_fingers(hand);
    for (int i = 0; i < 3; ++i) state_.pointed_mm[i] = holds ? state_.hook_mm[i] : pointed_.x_mm[i];
  }
}

void VirtualHand::note_fingers(const HandPose& hand) {
  for (int i = 0; i < 3; ++i) {
    state_.forefinger_mm[i] = hand.forefinger.tip_mm[i], state_.thumb_mm[i] = hand.thumb.tip_mm[i];
    state_.pointing[i] = hand.pointing[i];
  }
  // Of a closed hand the tips say nothing of its turn about the forefinger.
  constexpr double kOpen_mm = 35, kSlow = 0.005;  // 0.2 s
  Vec3 across = hand.thumb.tip_mm - hand.forefinger.tip_mm;
  across -= across.dot(hand.pointing) * hand.pointing;
  if (const double wide = across.norm(); wide > kOpen_mm) {
    const Vec3 seen = hand.orientation.conjugate() * (across / wide);
    const Vec3 mean = thumbwards_ + (thumbwards_.norm() > 0 ? kSlow : 1) * (seen - thumbwards_);
    if (mean.norm() > 1e-3) thumbwards_ = mean.normalized();
  }
  const Vec3 now = hand.orientation * thumbwards_;
  for (int i = 0; i < 3; ++i) state_.thumbwards[i] = now[i];
}

void VirtualHand::show_at_cursor(const HandPose& hand, bool there, const Vec3& cursor_mm) {
  state_.valid = hand.valid;
  state_.closed = hand.closed;
  if (!hand.valid) return;
  opening_ = {};
  was_closed_ = hand.closed;
  state_.points = there;
  note_fingers(hand);
  for (int i = 0; i < 3; ++i) state_.centre_mm[i] = hand.centre_mm[i], state_.pointed_mm[i] = cursor_mm[i];
}

}  // namespace limberg
