#include "sim/geometry/overrun.h"

#include <algorithm>

#include "sim/geometry/polyline.h"

namespace limberg {

size_t points_to_closing(std::span<const Vec2> p) {
  const size_t n = p.size();
  if (n < 4) return n;
  const double length = path_length(p);
  if (!(length > 0)) return n;
  double walked = 0, nearest = 1e30, left = 0;
  size_t keep = n;
  const auto passes = [&](double distance, size_t points, double from_start) {
    if (distance >= nearest) return;
    nearest = distance, keep = points, left = length - from_start;
  };
  for (size_t i = 1; i < n; ++i) {
    const Vec2 edge = p[i] - p[i - 1];
    const double way = edge.norm();
    walked += way;
    if (walked < length * 2 / 3) continue;
    // Along an edge that is longer than what may be passed by the place is between its ends; a hand's points are near.
    if (const double at = (p[0] - p[i - 1]).dot(edge) / std::max(way, 1e-12); way > kPasses_mm && at > 0 && at < way)
      passes(distance_to_segment(p[0], p[i - 1], p[i]), i, walked - way + at);
    passes((p[i] - p[0]).norm(), i + 1, walked);
  }
  return nearest <= kPasses_mm && left <= kRunsOn_mm ? keep : n;
}

}  // namespace limberg
