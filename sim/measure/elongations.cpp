#include "sim/measure/elongations.h"

#include <algorithm>
#include <cmath>

namespace limberg {

std::optional<Elongations> elongations(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
                                       const CentralLimb& limb) {
  const auto ends = limb_ends(view, x_mm, skin, limb);
  if (!ends) return std::nullopt;
  const auto& [a, b, before] = *ends;
  Elongations e;
  e.direct = (b - a).norm() / before;
  const Vec3 n = skin.frame(0.5 * (a + b)).normal, flat = (b - a) - (b - a).dot(n) * n;
  const double length = flat.norm();
  e.planimetric = length / before;
  if (!(length > 0)) return e;
  const Vec3 along = flat / length, side = n.cross(along);
  // Every skin triangle's line in the plane through a, along and n.
  struct Piece {
    double s0, h0, s1, h1;
  };
  std::vector<Piece> pieces;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    Vec3 x[3];
    double d[3];
    for (size_t k = 0; k < 3; ++k) x[k] = x_mm[size_t(view.tri[t][k])].cast<double>() - a, d[k] = x[k].dot(side);
    if ((d[0] > 0 && d[1] > 0 && d[2] > 0) || (d[0] < 0 && d[1] < 0 && d[2] < 0)) continue;
    std::vector<Vec2> cut;
    for (size_t k = 0; k < 3; ++k) {
      const size_t m = (k + 1) % 3;
      if ((d[k] > 0) == (d[m] > 0)) continue;
      const Vec3 q = x[k] + (x[m] - x[k]) * (d[k] / (d[k] - d[m]));
      cut.push_back({q.dot(along), q.dot(n)});
    }
    if (cut.size() != 2) continue;
    if (cut[0].x() > cut[1].x()) std::swap(cut[0], cut[1]);
    if (cut[1].x() > 0 && cut[0].x() < length) pieces.push_back({cut[0].x(), cut[0].y(), cut[1].x(), cut[1].y()});
  }
  std::sort(pieces.begin(), pieces.end(), [](const Piece& p, const Piece& q) { return p.s0 < q.s0; });
  double at = 0, sum = 0;  // what lies over what is counted already does not count again
  for (const Piece& p : pieces) {
    const double from = std::max(p.s0, at), to = std::min(p.s1, length);
    if (to <= from) continue;
    sum += from - at;  // a gap
    const double slope = (p.h1 - p.h0) / std::max(p.s1 - p.s0, 1e-12);
    sum += (to - from) * std::sqrt(1 + slope * slope);
    at = to;
  }
  e.stereometric = (sum + length - at) / before;
  return e;
}

}  // namespace limberg
