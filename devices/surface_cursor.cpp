#include "devices/surface_cursor.h"

#include <algorithm>

namespace limberg {

SurfaceCursor::SurfaceCursor(const CursorSettings& settings)
    : set_(settings), walk_(settings.ground), path_(kPathPoints), step_(settings.step_mm) {
  set_gain(settings.gain);
}

void SurfaceCursor::set_gain(double gain) { set_.gain = std::clamp(gain, 0.05, 2.0); }

void SurfaceCursor::set_ground(Ground ground) {
  if (ground == set_.ground) return;
  set_.ground = ground;
  walk_ = SurfaceWalk(ground);
  placed_ = false;
}

bool SurfaceCursor::put(const Snapshot& s, const Vec3& x_mm) {
  placed_ = false;
  if (!has_surface(s)) return false;
  return put(s, walk_.nearest(s, x_mm));
}

bool SurfaceCursor::put(const Snapshot& s, const SurfacePlace& place) {
  placed_ = false;
  if (!has_surface(s) || place.triangle < 0 || size_t(place.triangle) >= s.topology->view.tri.size()) return false;
  place_ = place;
  placed_ = true, version_ = s.topology->version;
  hand_known_ = was_drawing_ = false;
  left_ = Vec3::Zero();
  look(s);
  return true;
}

void SurfaceCursor::look(const Snapshot& s) {
  x_ = walk_.position(s, place_);
  X_ = walk_.rest_position(s, place_);
  normal_ = walk_.normal(s, place_);
}

bool SurfaceCursor::follow_topology(const Snapshot& s) {
  if (version_ == s.topology->version) return true;
  version_ = s.topology->version;
  const Vec3 X = X_;
  const SurfacePlace found = walk_.nearest_at_rest(s, X, x_);
  if (found.triangle < 0) return placed_ = false;
  place_ = found;
  if ((walk_.rest_position(s, place_) - X).norm() > 1e-3) ++relocated_;
  return true;
}

void SurfaceCursor::note(const Snapshot& s, bool first) {
  if (first) path_n_ = 0, step_ = set_.step_mm;
  if (!first && path_n_ > 0 && (X_ - path_[path_n_ - 1].X_mm).norm() < step_) return;
  if (path_n_ == path_.size()) {
    for (size_t i = 0; 2 * i < path_n_; ++i) path_[i] = path_[2 * i];
    path_n_ = (path_n_ + 1) / 2;
    step_ *= 2;
  }
  path_[path_n_++] = {s.topology->to_chart(X_), X_, x_};
}

void SurfaceCursor::tick(const Snapshot& s, const Pose& hand, bool clutch, bool drawing) {
  if (!placed_ || !has_surface(s) || !follow_topology(s)) return;
  if (!hand.valid) {
    hand_known_ = false;  // where it comes back is a new start
  } else {
    const Vec3 way = hand.tip_mm - hand_;
    if (hand_known_ && !clutch && way.norm() <= kMostPerTick_mm)
      left_ = walk_.walk(s, place_, left_ + set_.gain * way);
    else
      left_ = Vec3::Zero();
    hand_ = hand.tip_mm;
    hand_known_ = true;
  }
  look(s);
  if (drawing) note(s, !was_drawing_);
  was_drawing_ = drawing;
}

}  // namespace limberg
