#include "sim/skull/bone/gaps.h"

#include <algorithm>
#include <cmath>

namespace limberg::bone {
namespace {

constexpr double kSame_mm = 0.3, kNothing_mm = 1e-6;

bool on_wall(const WallPoint& p, const FragmentShape& b) {
  if (b.walls.empty()) return false;
  const Bvh::Closest c = b.walls.closest(p.x_mm, kSame_mm);
  return c.triangle >= 0 && b.surface.normal(c.triangle).dot(p.normal) < -0.7;
}

/// Deepest of b's places (vertices and face centres) within a, and the box of all that lie within (frame of a).
double deepest(const FragmentShape& a, const FragmentShape& b, const Eigen::Isometry3d& b_in_a,
               const Eigen::Isometry3d& to_box, Vec3& lo, Vec3& hi) {
  double most = 0;
  std::vector<uint8_t> seen(b.surface.X_mm.size(), 0);
  for (const Tri& t : b.surface.tri)
    for (int32_t v : t) {
      if (seen[size_t(v)]++) continue;
      const Vec3 x = b_in_a * b.surface.X_mm[size_t(v)];
      if ((x.array() < a.lo_mm.array()).any() || (x.array() > a.hi_mm.array()).any()) continue;
      if (!a.surface.contains(x)) continue;
      const double deep = a.surface.bvh.closest(x).distance_mm;
      if (deep < kNothing_mm) continue;
      most = std::max(most, deep);
      const Vec3 y = to_box * x;
      lo = lo.cwiseMin(y), hi = hi.cwiseMax(y);
    }
  return most;
}

/// Where a line along z is inside a closed surface, as places along it in pairs.
std::vector<double> inside(const BoneSurface& s, const Vec3& origin, const Vec3& along, double length) {
  std::vector<double> at;
  int depth = 0;
  for (const Bvh::LineHit& h : s.bvh.line(origin, along, 0, length)) {
    if (!at.empty() && h.t - at.back() < 1e-9 && (depth > 0) == h.from_outside) continue;  // a shared edge, met twice
    if (h.from_outside) {
      if (depth++ == 0) at.push_back(h.t);
    } else {
      if (depth == 0) {
        if (at.empty())
          at.push_back(0), depth = 1;  // it began inside
        else
          continue;
      }
      if (--depth == 0) at.push_back(h.t);
    }
  }
  if (at.size() % 2) at.push_back(length);
  return at;
}

double overlap(const FragmentShape& a, const FragmentShape& b, const Eigen::Isometry3d& b_in_a, const Vec3& lo,
               const Vec3& hi) {
  const Eigen::Isometry3d a_in_b = b_in_a.inverse();
  constexpr int n = 64;
  const Vec3 size = hi - lo;
  const double hx = size.x() / n, hy = size.y() / n;
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      // A little off the middle, so that no line runs along an edge of a symmetric mesh.
      const Vec3 o = lo + Vec3((i + 0.4871) * hx, (j + 0.5137) * hy, 0);
      const std::vector<double> p = inside(a.surface, o, Vec3::UnitZ(), size.z());
      if (p.empty()) continue;
      const std::vector<double> q = inside(b.surface, a_in_b * o, a_in_b.linear() * Vec3::UnitZ(), size.z());
      for (size_t k = 0; k + 1 < p.size(); k += 2)
        for (size_t l = 0; l + 1 < q.size(); l += 2)
          sum += std::max(0., std::min(p[k + 1], q[l + 1]) - std::max(p[k], q[l]));
    }
  return sum * hx * hy;
}

}  // namespace

double seam_mm2(const FragmentShape& a, const FragmentShape& b) {
  double sum = 0;
  for (const WallPoint& p : a.wall)
    if (on_wall(p, b)) sum += p.area_mm2;
  return sum;
}

Gap measure_gap(const FragmentShape& a, const FragmentShape& b, const Eigen::Isometry3d& b_in_a) {
  Gap g;
  g.a = a.id, g.b = b.id;
  const Eigen::Isometry3d a_in_b = b_in_a.inverse();
  double area = 0;
  for (const WallPoint& p : a.wall) {
    if (!on_wall(p, b)) continue;
    const Vec3 x = a_in_b * p.x_mm;
    area += p.area_mm2;
    if (b.surface.contains(x)) continue;
    const double d = b.walls.closest(x).distance_mm;
    g.gap_mean_mm += p.area_mm2 * d, g.gap_max_mm = std::max(g.gap_max_mm, d);
  }
  if (area > 0) g.gap_mean_mm /= area;
  Vec3 lo = Vec3::Constant(1e300), hi = -lo;
  g.overlap_max_mm =
      std::max(deepest(a, b, b_in_a, Eigen::Isometry3d::Identity(), lo, hi), deepest(b, a, a_in_b, b_in_a, lo, hi));
  if (g.overlap_max_mm > kNothing_mm) {
    // The places are some mm apart: the overlap may reach so far beyond them.
    lo -= Vec3::Constant(4), hi += Vec3::Constant(4);
    g.overlap_mm3 = overlap(a, b, b_in_a, lo.cwiseMax(a.lo_mm), hi.cwiseMin(a.hi_mm));
  }
  return g;
}

}  // namespace limberg::bone
