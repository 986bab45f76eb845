#include "devices/gestures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "devices/held_place.h"
#include "sim/base/elementary.h"

namespace limberg {

namespace {

constexpr double kNearMm = 20;      // within this of the skin the closest point is followed on every tick
constexpr int64_t kSearchNear = 4;  // ticks between searches over all the skin
constexpr int64_t kSearchFar = 16;
constexpr double kJumpMm = 3;     // along a stroke the touched point may run ahead of the hand by so much ...
constexpr double kJumpPerMm = 3;  // ... and by this factor; further is another sheet of skin
constexpr double kTicksPerMs = 1;

bool draws(Tool t) {
  return t == Tool::scalpel || t == Tool::scalpel_through || t == Tool::undermine || t == Tool::excise ||
         sews_along(t) || t == Tool::saw || t == Tool::marker || t == Tool::swab;
}

constexpr int64_t kNoThread = -1, kInHand = -2;  // instead of the tick at which it was laid down

bool holds_thread(Tool t) { return t == Tool::suture_bites || t == Tool::suture_knot; }

}  // namespace

ToolEvent Gestures::event(int kind, int64_t tick, const Snapshot& s) const {
  ToolEvent e;
  e.tick = tick;
  e.snapshot = s.step;
  e.kind = kind;
  e.tool = int32_t(tool_);
  e.chart_x = touch_.chart.x();
  e.chart_y = touch_.chart.y();
  for (int i = 0; i < 3; ++i) e.world_mm[i] = e.seen_mm[i] = touch_.x_mm[i], e.rest_mm[i] = touch_.X_mm[i];
  const Vec3 out = out_at_rest(s);
  for (int i = 0; i < 3; ++i) e.out[i] = out[i];
  e.depth_mm = depth_mm_;
  e.angle_deg = angle_deg_ > 0 || tool_ == Tool::scalpel_through ? angle_deg_ : 90;
  e.spacing_mm = spacing_mm_;
  return e;
}

void Gestures::emit(ToolEvent e, EventSink& out) {
  e.seq = seq_++;
  // What gives a begun row up, as CommandBuilder sees it.
  const bool of_a_row = sews_along(Tool(e.tool)) && e.kind < ToolEvent::stroke_cancel;
  row_begun_ &= of_a_row || (e.kind != ToolEvent::stroke_begin && e.kind != ToolEvent::stroke_cancel &&
                             e.kind != ToolEvent::undo && e.kind != ToolEvent::redo && e.kind != ToolEvent::told);
  if (!out.push(e)) ++lost_;
}

void Gestures::miss(int kind, int64_t tick, EventSink& out) {
  missed_ += kind != MissedPress::same_edge;  // that stitch is tied
  MissedPress m;
  m.tick = tick, m.kind = kind, m.tool = int32_t(tool_);
  for (int i = 0; i < 3; ++i) m.tip_mm[i] = last_pose_.tip_mm[i];
  m.distance_mm = touch_.triangle >= 0 ? touch_.distance_mm : 1e30;
  out.missed(m);
}

double Gestures::apart(const SkinTouch& a, const SkinTouch& b) const {
  return acts_on_bone(tool_) || g_.in_space ? (a.X_mm - b.X_mm).norm() : (a.chart - b.chart).norm();
}

void Gestures::find_touch(int64_t tick, const Pose& pose, const Snapshot& s) {
  if (!s.topology || s.x_mm.size() != s.topology->view.X_mm.size()) {
    touch_ = {};
    return;
  }
  const bool another = index().another(s);
  if (another) {
    touch_.triangle = -1;
    if (doing_ == Doing::stroke && sews_along(tool_)) edge_.found_again(index_, s);
    for (int i = 0; i < state_.bites; ++i) bite_[size_t(i)] = index().closest(s, bite_[size_t(i)].x_mm, -1);
  }
  const bool near = touch_.triangle >= 0 && touch_.distance_mm < kNearMm;
  const int32_t hint = near ? touch_.triangle : -1;
  const bool search = another || tick % (near ? kSearchNear : kSearchFar) == 0;
  if (near) {
    touch_ = index().closest(s, pose.tip_mm, hint);
  } else if (!search) {
    touch_.distance_mm = std::max(touch_.distance_mm, kNearMm);
    return;
  }
  if (search) {
    const SkinTouch all = index().closest(s, pose.tip_mm, -1);
    if (all.triangle >= 0 && (touch_.triangle < 0 || !near || all.distance_mm < touch_.distance_mm)) touch_ = all;
  }
}

Vec3 Gestures::meant_tip() const {
  if (recent_ < kRestTicks) return last_pose_.tip_mm;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& tip : recent_tip_) {
    if ((tip - last_pose_.tip_mm).norm() > g_.rest_mm) return last_pose_.tip_mm;
    mean += tip / double(kRestTicks);
  }
  return mean;
}

/// Where the hand rests, the touched point is that of the mean tip.
void Gestures::touch_where_rested(const Snapshot& s) {
  if (recent_ < kRestTicks || touch_.triangle < 0) return;
  const SkinTouch rested =
      g_.in_space ? index().closest_of_all(s, meant_tip()) : index().closest(s, meant_tip(), touch_.triangle);
  if (rested.triangle >= 0) touch_ = rested;
}

void Gestures::control(const ControlSample& c, int64_t tick, const Snapshot& s, EventSink& out) {
  switch (c.kind) {
    case ControlSample::select_tool: {
      const double depth_mm = c.value[kDepth] > 0 ? c.value[kDepth] : g_.default_depth_mm,
                   spacing_mm = c.value[kSpacing] > 0 ? c.value[kSpacing] : g_.default_spacing_mm;
      cancel(tick, s, out);
      // A row that is begun is given up for another; a slider only says another depth or spacing.
      const bool again = c.tool == tool_ && depth_mm == depth_mm_ && spacing_mm == spacing_mm_;
      if (g_.in_space && sews_along(tool_) && again) emit(event(ToolEvent::stroke_cancel, tick, s), out);
      if (acts_on_bone(tool_) != acts_on_bone(c.tool) || (tool_ == Tool::suture_deep) != (c.tool == Tool::suture_deep))
        touch_ = {};  // another ground
      if (holds_thread(c.tool))
        laid_down_ = kInHand, knotted_ = c.tool == Tool::suture_bites ? 0 : knotted_;
      else if (laid_down_ == kInHand && c.tool != Tool::swab)
        laid_down_ = g_.threads_slip ? tick : kNoThread;
      tool_ = c.tool;
      depth_mm_ = depth_mm, spacing_mm_ = spacing_mm;
      angle_deg_ = c.value[kAngle] > 0 && c.value[kAngle] < 180 ? c.value[kAngle] : 0;
      asked_hook_ = c.value[kHookId] >= 1 && c.value[kHookId] <= 1e6 ? int32_t(c.value[kHookId]) : 0;
      break;
    }
    case ControlSample::undo:
      cancel(tick, s, out);
      emit(event(ToolEvent::undo, tick, s), out);
      break;
    case ControlSample::redo:
      cancel(tick, s, out);
      emit(event(ToolEvent::redo, tick, s), out);
      break;
    case ControlSample::stage: {
      ToolEvent e = event(ToolEvent::stage, tick, s);
      e.id = int32_t(std::clamp(c.value[0], 0.0, 1e6));
      e.text = c.text;
      emit(e, out);
      break;
    }
    case ControlSample::release_hook: {
      ToolEvent e = event(ToolEvent::hook_release, tick, s);
      e.id = int32_t(std::clamp(c.value[0], 0.0, 1e6));
      if (doing_ == Doing::hold_hook && state_.held_hook == e.id) {
        doing_ = Doing::nothing;
        state_.held_hook = 0;
      }
      emit(e, out);
      break;
    }
    case ControlSample::name_place:
      if (const auto on = int(std::clamp(c.value[3], 0.0, 3.0)); on == kTouchedBone || on == kFaceNearTip) {
        name_place(c, tick, s, out);
        break;
      }
      [[fallthrough]];
    default:
      old_control(c, tick, s, out);
      break;
  }
  state_.tool = int32_t(tool_);
}

void Gestures::name_place(const ControlSample& c, int64_t tick, const Snapshot& s, EventSink& out) {
  const bool on_face = int(c.value[3]) >= kFaceNearTip;
  if (!on_face && (touch_.triangle < 0 || touch_.distance_mm > g_.reach_mm || !acts_on_bone(tool_))) {
    miss(MissedPress::place, tick, out);
    return;
  }
  ToolEvent e = event(ToolEvent::name_place, tick, s);
  for (int i = 0; i < 3 && on_face; ++i) e.rest_mm[i] = last_pose_.tip_mm[i];
  e.id = on_face;
  e.text = c.text;
  emit(e, out);
}

void Gestures::command(const std::shared_ptr<const Command>& c, int64_t tick, const Snapshot& s, EventSink& out) {
  if (!c) return;
  const auto* of_head = std::get_if<HeadCommand>(c.get());
  const bool leaves_tissue =
      of_head && (std::holds_alternative<PlaceLandmark>(*of_head) || std::holds_alternative<ConnectTissue>(*of_head) ||
                  std::holds_alternative<Superpose>(*of_head));
  if (!leaves_tissue) cancel(tick, s, out);
  ToolEvent e = event(ToolEvent::told, tick, s);
  e.command = c;
  emit(e, out);
}

void Gestures::old_control(const ControlSample& c, int64_t tick, const Snapshot& s, EventSink& out) {
  if (c.kind < OldControls::kFirst || c.kind > OldControls::kLast || c.kind == ControlSample::clutch) return;
  const OldControls::Told told = old_.read(c, s);
  if (told.stops_hand) cancel(tick, s, out);
  if (!told.understood) miss(MissedPress::control, tick, out);
  if (c.kind == OldControls::snap) ++bone_grabs_;  // it was a grab of the hand, and the hand's grabs are counted
  for (const auto& command : told.events) {
    ToolEvent e = event(ToolEvent::told, tick, s);
    e.command = command;
    emit(e, out);
  }
}

/// A hook asked for by number is that hook, taken if it stands here and set if it stands nowhere; without a number the
/// nearest handle within reach is taken.
void Gestures::press_hook(int64_t tick, const Pose& pose, const Snapshot& s, EventSink& out) {
  const HookState* take = nullptr;
  bool stands = false;
  double best = g_.handle_reach_mm;
  for (const HookState& h : s.hooks) {
    stands |= h.id == asked_hook_;
    next_hook_ = std::max(next_hook_, h.id + 1);
    const double d = (h.handle_mm.cast<double>() - pose.tip_mm).norm();
    if ((asked_hook_ == 0 || h.id == asked_hook_) && d <= best) best = d, take = &h;
  }
  ToolEvent e = event(take ? ToolEvent::hook_take : ToolEvent::hook_set, tick, s);
  if (!take && (!on_ground() || stands)) {
    miss(stands ? MissedPress::hook_stands : MissedPress::press, tick, out);
    return;
  }
  e.id = take ? take->id : asked_hook_ > 0 ? asked_hook_ : next_hook_;
  next_hook_ = std::max(next_hook_, e.id + 1);
  for (int i = 0; i < 3; ++i) e.world_mm[i] = pose.tip_mm[i];
  state_.held_hook = e.id;
  doing_ = Doing::hold_hook;
  emit(e, out);
}

/// The hook that is nearest, at its handle or where it holds the skin; of one asked for by number that one.
void Gestures::take_hook_out(int64_t tick, const Pose& pose, const Snapshot& s, EventSink& out) {
  const HookState* take = nullptr;
  double best = g_.handle_reach_mm;
  for (const HookState& h : s.hooks)
    for (const Vec3f* at : {&h.handle_mm, &h.at_mm})
      if (asked_hook_ > 0 && h.id != asked_hook_)
        continue;
      else if (const double d = (at->cast<double>() - pose.tip_mm).norm(); d <= best)
        best = d, take = &h;
  if (!take) return miss(MissedPress::no_hook, tick, out);
  ToolEvent e = event(ToolEvent::hook_release, tick, s);
  e.id = take->id;
  emit(e, out);
}

bool Gestures::at_an_edge(const Snapshot& s) const {
  const SurfaceView& view = s.topology->view;
  for (size_t t = 0; t < view.rim.size(); ++t)
    for (size_t k = 0; view.rim[t] != 0 && k < 3; ++k) {
      if (!(view.rim[t] >> k & 1)) continue;
      const Vec3 a = s.x_mm[size_t(view.tri[t][k])].cast<double>(),
                 b = s.x_mm[size_t(view.tri[t][(k + 1) % 3])].cast<double>(), ab = b - a;
      const double along = std::clamp((touch_.x_mm - a).dot(ab) / std::max(ab.squaredNorm(), 1e-12), 0.0, 1.0);
      if ((a + along * ab - touch_.x_mm).norm() <= g_.edge_mm) return true;
    }
  return false;
}

void Gestures::press_scissors(int64_t tick, const Snapshot& s, EventSink& out) {
  for (const SutureState& k : s.sutures)
    for (const Vec3f* at : {&k.a_mm, &k.b_mm})
      if ((at->cast<double>() - touch_.x_mm).norm() <= g_.stitch_mm)
        return emit(event(ToolEvent::suture_cut, tick, s), out);
  if (!at_an_edge(s)) return miss(MissedPress::no_edge, tick, out);
  begin_stroke(tick, s, out);
}

void Gestures::begin_stroke(int64_t tick, const Snapshot& s, EventSink& out) {
  doing_ = Doing::stroke;
  last_stroke_ = touch_;
  angle_sum_deg_ = angle_weight_mm_ = 0;
  emit(event(ToolEvent::stroke_begin, tick, s), out);
}

/// Where bank lies on bank the needle means the one that it has not gone through yet. Whether it has found one.
bool Gestures::take_other_bank(const Snapshot& s, const SkinTouch& first) {
  if (g_.in_space && SurfaceIndex::edge_between(s, first, touch_)) return true;
  const SkinTouch apart = index_.closest_apart(s, meant_tip(), first, g_.apart_mm, g_.in_space);
  if (apart.triangle < 0) return false;
  touch_ = apart;
  return true;
}

/// The needle goes in, for the first or, of a corner's stitch, for the third time.
void Gestures::bite(const Snapshot& s, EventSink& out, int64_t tick) {
  if (corner_waits_) {
    corner_waits_ = false, state_.bites = 0;
    take_other_bank(s, bite_[1]);
    return emit(event(ToolEvent::suture_b, tick, s), out);
  }
  doing_ = Doing::suture;
  bite_[0] = touch_, state_.bites = 1;
  emit_bite(ToolEvent::suture_a, tick, s, out);
}

/// A cut face along the skin looks away from it (a flap's underside) or towards it (its bed); across it, it is a wall.
void Gestures::emit_bite(int kind, int64_t tick, const Snapshot& s, EventSink& out) {
  ToolEvent e = event(kind, tick, s);
  if (tool_ == Tool::suture_deep && s.topology->view.kind[size_t(touch_.triangle)] == FaceKind::wall) {
    constexpr double kInto_mm = 0.2;
    const SkinTouch skin = index_.closest(s, touch_.x_mm, -1);
    e.side = int32_t(skin.triangle >= 0 ? side_of_face(touch_.N, skin.N) : HeldSide::wall);
    for (int i = 0; i < 3; ++i) e.rest_mm[i] -= kInto_mm * touch_.N[i];
  }
  emit(e, out);
}

void Gestures::press_knot(int64_t tick, const Snapshot& s, EventSink& out) {
  const SewnThread& t = s.sewn;
  if (t.thread == 0 || (t.end_mm.cast<double>() - touch_.x_mm).norm() > g_.knot_mm)
    return miss(MissedPress::no_thread, tick, out);
  knotted_ = t.thread;
  emit(event(ToolEvent::suture_knot, tick, s), out);
}

void Gestures::let_thread_go(int64_t tick, const Snapshot& s, EventSink& out) {
  constexpr int64_t kSeenLate = 1000;  // ticks
  if (laid_down_ < 0 || tick - laid_down_ > kSeenLate) return;
  if (s.sewn.thread == 0 || s.sewn.let_go || s.sewn.thread == knotted_) return;
  laid_down_ = kNoThread;
  emit(event(ToolEvent::suture_let_go, tick, s), out);
}

/// Let go: across the wound, or in the tip of a flap.
void Gestures::second_bite(int64_t tick, const Snapshot& s, EventSink& out) {
  state_.bites = 0;
  if (touch_.triangle < 0 || touch_.distance_mm > g_.lift_mm) {
    miss(MissedPress::second_bite, tick, out);
    return emit(event(ToolEvent::suture_cancel, tick, s), out);
  }
  if (tool_ == Tool::suture_deep) return emit_bite(ToolEvent::suture_b, tick, s, out);  // cut faces say where they are
  if (!take_other_bank(s, bite_[0]) && (touch_.x_mm - bite_[0].x_mm).norm() < SurfaceIndex::kSheetRadius_mm)
    miss(MissedPress::same_edge, tick, out);
  if (tool_ == Tool::suture_corner) {
    bite_[1] = touch_, state_.bites = 2, corner_waits_ = true;
    return emit(event(ToolEvent::suture_tip, tick, s), out);
  }
  emit(event(ToolEvent::suture_b, tick, s), out);
}

/// Where the skin has taken them since.
void Gestures::show_bites(const Snapshot& s) {
  for (int i = 0; i < state_.bites; ++i) {
    SkinTouch& b = bite_[size_t(i)];
    if (b.triangle >= 0) b = touch_at(s, b.triangle, b.bary, 0);
    for (int k = 0; k < 3; ++k) state_.bite_mm[i][k] = b.x_mm[k];
  }
}

void Gestures::press(int64_t tick, const Pose& pose, const Snapshot& s, EventSink& out) {
  if (tool_ == Tool::hook) return press_hook(tick, pose, s, out);
  if (tool_ == Tool::hook_out) return take_hook_out(tick, pose, s, out);
  if (tool_ != Tool::none && !on_ground()) {
    if (tool_ != Tool::swab) miss(MissedPress::press, tick, out);  // a swab is as often pressed into the wound
  } else if (tool_ == Tool::grab) {
    ToolEvent e = event(ToolEvent::bone_grab, tick, s);
    e.id = ++bone_grabs_;
    grip_.begin(pose.tip_mm, pose.orientation, 1);
    state_.carried = carried(grip_.motion(), e.id);
    doing_ = Doing::carry;
    emit(e, out);
  } else if (tool_ == Tool::scissors) {
    press_scissors(tick, s, out);
  } else if (tool_ == Tool::suture_knot) {
    press_knot(tick, s, out);
  } else if (sews_bites(tool_)) {
    bite(s, out, tick);
  } else if (sews_along(tool_)) {  // told when it is known on which skin it was drawn
    doing_ = Doing::stroke;
    const auto from_tip = [&](const SkinTouch& t) { return (t.x_mm - meant_tip()).norm(); };
    const SkinTouch& nearer = row_edge_[from_tip(row_edge_[1]) < from_tip(row_edge_[0])];
    if (g_.as_meant)
      edge_.begin_as_meant(index_, s, meant_tip(), row_begun_ ? &nearer : nullptr);
    else
      edge_.begin(index_, s, meant_tip());
    edge_.note(pose.tip_mm, 0);
  } else if (draws(tool_)) {
    begin_stroke(tick, s, out);
  }
}

/// The angle between the skin left of the path and the handle, in the plane across the path: below 90 degrees the
/// handle leans to the left and the blade's edge lies to the right, as a stroke counts it (drawn_stroke.h).
void Gestures::add_blade_angle(const Pose& pose, const Vec3& travelled_mm) {
  const Vec3& n = touch_.normal;
  const Vec3 along = travelled_mm - travelled_mm.dot(n) * n;
  const double length = along.norm();
  if (length < 1e-6) return;
  const Vec3 left = n.cross(along / length);
  const double up = pose.shaft.dot(n), aside = pose.shaft.dot(left);
  if (up <= 0.05) return;  // the handle lies on the skin: says nothing
  angle_sum_deg_ += length * elementary::atan2(up, aside) * 180 / std::numbers::pi;
  angle_weight_mm_ += length;
}

/// The skin's turn since it was at rest is taken back from the shaft: both are seen from the touched triangle, along
/// its first edge, across it and out of it. A shaft that lies on the skin, or points into it, says nothing.
Vec3 Gestures::out_at_rest(const Snapshot& s) const {
  if (tool_ != Tool::scalpel_through || angle_deg_ > 0 || touch_.triangle < 0) return touch_.N;
  const SurfaceView& v = s.topology->view;
  const Tri& k = v.tri[size_t(touch_.triangle)];
  constexpr double kAlmostFlat = 0.2;  // cosine between shaft and skin's normal: 78 degrees
  if (last_pose_.shaft.dot(touch_.normal) < kAlmostFlat) return touch_.N;
  const auto triad = [](const Vec3& edge, const Vec3& n) {
    Mat3 m;
    m.col(0) = (edge - edge.dot(n) * n).normalized(), m.col(2) = n, m.col(1) = n.cross(m.col(0));
    return m;
  };
  const Vec3 edge = (s.x_mm[size_t(k[1])] - s.x_mm[size_t(k[0])]).cast<double>(),
             E = v.X_mm[size_t(k[1])] - v.X_mm[size_t(k[0])];
  const Vec3 out = triad(E, touch_.N) * triad(edge, touch_.normal).transpose() * last_pose_.shaft;
  return out.allFinite() && out.norm() > 0 ? Vec3(out.normalized()) : touch_.N;
}

double Gestures::blade_angle_deg() const {
  if (angle_deg_ > 0 || tool_ == Tool::scalpel_through) return angle_deg_;
  return angle_weight_mm_ > 0 ? std::clamp(angle_sum_deg_ / angle_weight_mm_, 20.0, 160.0) : 90;
}

void Gestures::stroke_on(int64_t tick, const Pose& pose, const Snapshot& s, EventSink& out) {
  if (touch_.triangle < 0) return;
  if (touch_.distance_mm > g_.lift_mm) return release(tick, pose, s, out);
  if (sews_along(tool_)) {
    edge_.follow(index_, s, pose.tip_mm);
    edge_.note(pose.tip_mm, g_.step_mm);
    return;
  }
  const double step = apart(touch_, last_stroke_);
  if (step < g_.step_mm) return;
  const Vec3 travelled = touch_.x_mm - last_stroke_.x_mm;
  const double hand = (pose.tip_mm - last_drawn_tip_).norm();
  if (step > kJumpMm + kJumpPerMm * hand) return;
  add_blade_angle(pose, travelled);
  ToolEvent e = event(ToolEvent::stroke_point, tick, s);
  e.angle_deg = blade_angle_deg();
  emit(e, out);
  last_stroke_ = touch_;
  last_drawn_tip_ = pose.tip_mm;
}

void Gestures::release(int64_t tick, const Pose& pose, const Snapshot& s, EventSink& out) {
  const bool on_skin = touch_.triangle >= 0 && touch_.distance_mm <= g_.lift_mm;
  switch (doing_) {
    case Doing::stroke: {
      if (sews_along(tool_)) {
        if (on_skin) edge_.follow(index_, s, meant_tip());
        edge_.note(pose.tip_mm, 0.05);
        emit_row(tick, s, out);
        break;
      }
      const double step = apart(touch_, last_stroke_);
      if (on_skin && step > 0.05 && step < kJumpMm) emit(event(ToolEvent::stroke_point, tick, s), out);
      ToolEvent e = event(ToolEvent::stroke_end, tick, s);
      e.angle_deg = blade_angle_deg();
      emit(e, out);
      break;
    }
    case Doing::hold_hook: {
      ToolEvent e = event(ToolEvent::hook_leave, tick, s);
      e.id = state_.held_hook;
      for (int i = 0; i < 3; ++i) e.world_mm[i] = pose.tip_mm[i];
      state_.held_hook = 0;
      emit(e, out);
      break;
    }
    case Doing::suture:
      second_bite(tick, s, out);
      break;
    case Doing::carry: {
      const Carried c = state_.carried;
      ToolEvent e = event(ToolEvent::bone_drag, tick, s);
      e.id = c.holds;
      for (int i = 0; i < 3; ++i) e.world_mm[i] = c.shift_mm[i];
      for (int i = 0; i < 4; ++i) e.quat[i] = c.quat[i];
      emit(e, out);
      e.kind = ToolEvent::bone_release;
      emit(e, out);
      state_.carried = {};
      break;
    }
    case Doing::nothing:
      break;
  }
  doing_ = Doing::nothing;
}

void Gestures::emit_row(int64_t tick, const Snapshot& s, EventSink& out) {
  const SkinTouch now = touch_;
  for (size_t i = 0; i < edge_.size(); ++i) {
    touch_.chart = edge_.point(i).chart;
    touch_.x_mm = edge_.point(i).x_mm;
    touch_.X_mm = edge_.point(i).X_mm, touch_.N = edge_.point(i).N;
    emit(event(i == 0 ? ToolEvent::stroke_begin : ToolEvent::stroke_point, tick, s), out);
  }
  if (edge_.size() > 0) emit(event(ToolEvent::stroke_end, tick, s), out);
  touch_ = now;
  row_begun_ = !row_begun_ && edge_.size() > 0;
  for (size_t i = 0; i < 2 && row_begun_; ++i) {
    const EdgeStroke::Point& end = edge_.point(i == 0 ? 0 : edge_.size() - 1);
    row_edge_[i] = edge_.touched();
    row_edge_[i].chart = end.chart, row_edge_[i].x_mm = end.x_mm, row_edge_[i].X_mm = end.X_mm, row_edge_[i].N = end.N;
  }
}

void Gestures::cancel(int64_t tick, const Snapshot& s, EventSink& out) {
  if (doing_ == Doing::stroke && !sews_along(tool_)) emit(event(ToolEvent::stroke_cancel, tick, s), out);
  if (doing_ == Doing::suture || corner_waits_) emit(event(ToolEvent::suture_cancel, tick, s), out);
  state_.bites = 0, corner_waits_ = false;
  if (doing_ == Doing::hold_hook || doing_ == Doing::carry) release(tick, last_pose_, s, out);
  doing_ = Doing::nothing;
}

/// Where the tip of the tool is while the hand is there.
Vec3 Gestures::tool_tip(const Vec3& hand_mm, bool clutch) {
  if (doing_ != Doing::hold_hook && doing_ != Doing::carry) {
    shift_mm_ = Vec3::Zero();
    clutched_ = shifted_ = false;
  } else if (clutch || clutched_) {
    shift_mm_ = last_pose_.tip_mm - hand_mm;
    clutched_ = clutch, shifted_ = true;
    return last_pose_.tip_mm;
  }
  return shifted_ ? Vec3(hand_mm + shift_mm_) : hand_mm;
}

void Gestures::tick(int64_t tick, const Pose& hand, bool pressed, int edges, const Snapshot& s, EventSink& out,
                    bool clutch) {
  Pose pose = hand;
  if (hand.valid) pose.tip_mm = tool_tip(hand.tip_mm, clutch);
  state_.tick = tick;
  state_.tool = int32_t(tool_);
  state_.valid = pose.valid;
  let_thread_go(tick, s, out);
  if (!pose.valid) {
    // A gesture waits for the hand to come back; the hook that it holds stays where it is.
    state_.pressed = 0;
    if (doing_ != Doing::nothing) {
      if (lost_tick_ < 0) lost_tick_ = tick;
      if (!pressed)
        release(tick, last_pose_, s, out);
      else if (double(tick - lost_tick_) > g_.resume_ms * kTicksPerMs)
        cancel(tick, s, out);
    }
    recent_ = 0;
    pressed_ = pressed;  // a press that nobody saw the place of is not made up for
    return;
  }
  find_touch(tick, pose, s);
  show_bites(s);
  if (lost_tick_ >= 0) {
    lost_tick_ = -1;
    if (doing_ != Doing::nothing && (pose.tip_mm - last_pose_.tip_mm).norm() > g_.resume_mm) cancel(tick, s, out);
  }
  last_pose_ = pose;
  recent_tip_[recent_++ % kRestTicks] = pose.tip_mm;
  for (int i = 0; i < 3; ++i)
    state_.tip_mm[i] = pose.tip_mm[i], state_.shaft[i] = pose.shaft[i], state_.shift_mm[i] = shift_mm_[i];
  state_.pressed = pressed;

  // Two changes within one tick while pressed are a release and a new press.
  const bool again = pressed && pressed_ && edges >= 2;
  const bool changes = pressed != pressed_ || again;
  if (changes) touch_where_rested(s);
  if (!pressed || again) release(tick, pose, s, out);
  if (pressed && (!pressed_ || again)) {
    last_drawn_tip_ = pose.tip_mm;
    press(tick, pose, s, out);
  } else if (doing_ == Doing::carry) {
    state_.carried = carried(grip_.follow(pose.tip_mm, pose.orientation, clutch), state_.carried.holds);
  } else if (doing_ == Doing::stroke) {
    stroke_on(tick, pose, s, out);
  }
  pressed_ = pressed;
}

}  // namespace limberg
