// Strokes that begin or end on earlier cuts.
#include <algorithm>
#include <cmath>

#include "sim/cutting/blade_parts.h"

namespace limberg {

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
  const Vec2 d = (*wall - path[next]).normalized(), along = wounds.nearest(*wall).along;
  const double sine = std::abs(d.x() * along.y() - d.y() * along.x());
  path.erase(path.begin(), path.begin() + long(next));
  path.insert(path.begin(), *wall + d * (overshoot / std::clamp(sine, 0.2, 1.0)));
  return true;
}

}  // namespace limberg
