#include "sim/cutting/strokes/sheet_overlap.h"

#include <algorithm>
#include <cmath>

#include "sim/cutting/arrangement/store.h"

namespace limberg {

namespace {

// Both well beyond the jitter of 0.008. The sheet crosses the old one at kBelow / (kAbove + kBelow) of a mesh width
// from where it is below: near there.
constexpr double kAbove = 0.2, kBelow = 0.05;
constexpr double kParallel = 0.85;  // cosine between wall and sheet
constexpr double kSlanted = 0.2;    // and between the normal of a wall and a line that meets it

}  // namespace

std::optional<double> PocketMap::at(const Vec3& p_mm, const Vec3& n, const Vec3& up, double reach_mm) const {
  if (!arrangement_) return std::nullopt;
  const ArrangementStore& s = arrangement_->store();
  const double unit = s.grid.half_unit_mm(), reach = reach_mm / unit;
  const Vec3 p = (p_mm - s.grid.origin_mm) / unit;
  const Vec3 box = Vec3::Constant(reach / (n == up ? 1 : kSlanted));
  std::optional<double> best;
  s.blades_near(box_within(p - box, p + box), [&](int32_t o, const IntBox&) {
    if (s.orig[o].live == 0) return;
    for (int32_t f : s.faces_of(o)) {
      if (!s.face[f].has_side(0) || !s.face[f].has_side(1)) continue;  // a hole is no pocket
      const Vec3 &a = s.points.approx(s.face[f].v[0]), &b = s.points.approx(s.face[f].v[1]),
                 &c = s.points.approx(s.face[f].v[2]);
      const Vec3 m = (b - a).cross(c - a);
      const double across = m.dot(n);
      if (std::abs(m.dot(up)) < kParallel * m.norm() || std::abs(across) < kSlanted * m.norm())
        return;  // the whole original triangle stands upright
      const double h = m.dot(a - p) / across;
      const Vec3 q = p + h * n;
      const double off = n == up ? std::abs(h) : std::abs(h * across) / m.norm();
      if (off > reach || (best && std::abs(*best) <= std::abs(h) * unit)) continue;
      const double e = -1e-9 * m.squaredNorm();
      if ((b - a).cross(q - a).dot(m) < e || (c - b).cross(q - b).dot(m) < e || (a - c).cross(q - c).dot(m) < e)
        continue;
      best = h * unit;
    }
  });
  return best;
}

bool run_into_pockets(std::span<SheetVertex> sheet) {
  double raise = 0;
  bool any = false;
  for (const SheetVertex& v : sheet)
    if (v.covered) any = true, raise = std::max(raise, v.height + kAbove);
  if (!any) return false;
  for (SheetVertex& v : sheet) v.X_mm += v.normal * (v.deep ? v.height - kBelow : raise);
  return true;
}

}  // namespace limberg
