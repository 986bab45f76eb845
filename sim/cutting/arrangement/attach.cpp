// Strokes that begin or end on earlier cuts.
#include <algorithm>
#include <cmath>

#include "sim/cutting/strokes/blade_parts.h"
#include "sim/geometry/polyline.h"

namespace limberg {
namespace {

constexpr double kCornerClearance = 0.15;  // from the corner of an earlier cut, when joining it there
constexpr double kBeside = 0.05;           // more than jitter and grid move a blade

double sine_between(const Vec2& d, const Vec2& e) {
  return std::abs(d.x() * e.y() - d.y() * e.x());
}  // of unit vectors

/// Where a stroke that comes from `from` is to end, so far past the wall at w that it is through at a flat angle, too.
Vec2 past_wall(const WoundMap& wounds, const Vec2& from, const Vec2& w, double overshoot) {
  const Vec2 d = (w - from).normalized();
  return w + d * (overshoot / std::clamp(sine_between(d, wounds.nearest(w).along), 0.2, 1.0));
}

/// Is a stroke that ends there through a wall even when the blade lies a little to either side? At a corner of an
/// outline it may pass beside it, and a bridge of skin would be left.
bool is_through(const BladeContext& c, const WoundMap& wounds, const Vec2& from, const Vec2& end) {
  const Vec2 d = (end - from).normalized(), beside = kBeside * Vec2(-d.y(), d.x());
  if (!skin_is_live(c, end) && !skin_is_live(c, end + beside) && !skin_is_live(c, end - beside))
    return true;  // in a hole
  const Vec2 begin = end - std::min((end - from).norm(), 3 * kSnap) * d;
  return wounds.first_meeting(begin + beside, end + beside) && wounds.first_meeting(begin - beside, end - beside);
}

/// Past the wall at w; where that does not lead through it for sure, past one of the walls that meet there, the one
/// that is met least flatly.
Vec2 end_past(const BladeContext& c, const WoundMap& wounds, const Vec2& from, const Vec2& w, double overshoot) {
  const Vec2 straight = past_wall(wounds, from, w, overshoot);
  if (is_through(c, wounds, from, straight)) return straight;
  std::optional<Vec2> best;
  double most = 0;
  for (const WoundEdge& e : wounds.edges()) {
    if (distance_to_segment(w, e.a, e.b) > kCornerClearance || (e.a - e.b).norm() == 0) continue;
    const Vec2 along = (e.b - e.a).normalized();
    for (const double sign : {-1.0, 1.0}) {
      const Vec2 p = wounds.nearest(w + sign * kCornerClearance * along).point,
                 end = past_wall(wounds, from, p, overshoot);
      const double sine = sine_between((p - from).normalized(), along);
      if ((p - w).norm() > 0.5 * kCornerClearance && sine > most && is_through(c, wounds, from, end))
        most = sine, best = end;
    }
  }
  return best.value_or(straight);
}

}  // namespace

bool attach_start(const BladeContext& c, const WoundMap& wounds, std::vector<Vec2>& path, double overshoot) {
  if (wounds.empty()) return false;
  const bool live = skin_is_live(c, path[0]);
  std::optional<Vec2> wall;  // where the stroke is to pass through a wall
  size_t next = 0;           // the first point of the stroke that stays
  // Already past a wall: over a hole (any length of it), or across a cut by less than kSnap.
  double walked = 0;
  for (size_t i = 0; i + 1 < path.size() && !wall; ++i) {
    const double length = (path[i + 1] - path[i]).norm();
    const auto s = wounds.first_meeting(path[i], path[i + 1]);
    if (s && (!live || walked + *s * length <= kSnap)) wall = path[i] + (path[i + 1] - path[i]) * *s, next = i + 1;
    walked += length;
    if (live && walked > kSnap) break;
  }
  if (!wall && !live) return false;
  // Short of a wall: straight on, or to the nearest place.
  if (!wall) {
    const Vec2 ahead = heading_at_start(path, 2) * (2 * kSnap);
    if (const auto s = wounds.first_meeting(path[0], path[0] + ahead)) wall = path[0] + ahead * *s, next = 1;
  }
  if (!wall) {
    const WoundMap::Near near = wounds.nearest(path[0]);
    if (near.distance > kSnap) return false;
    wall = near.point;
  }
  wall = wounds.clear_of_ends(*wall, kEndClearance);
  // A point right beside the wall would turn the blade along it.
  while (next + 1 < path.size() && (path[next] - *wall).norm() < 1.5 * kEndClearance) ++next;
  const Vec2 past = end_past(c, wounds, path[next], *wall, overshoot);
  // Beside a wall that the stroke goes along, the place past it lies ahead: the stroke would have to double back.
  if (next == 0 && path.size() > 1 && (past - path[0]).normalized().dot(heading_at_start(path, 2)) < kDoublesBack)
    return false;
  path.erase(path.begin(), path.begin() + long(next));
  path.insert(path.begin(), past);
  return true;
}

}  // namespace limberg
