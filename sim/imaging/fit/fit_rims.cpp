// Where the rims of openings belong (fit_parts.h, Sight::rim).
//
// At the border of the data: on the isosurface in the border's own plane. Elsewhere on the crest between the outer
// surface and the wall of the cavity: the isosurface is followed in the plane across the rim, a little way outwards and
// a little way into the cavity; on the
// way its normal turns from that of the surface to that of the wall, and where it has turned half of that is the crest.
// (Of a corner that is rounded evenly this is its middle, whatever the radius; turning adds up, so that noise cancels.)
#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/base/elementary.h"
#include "sim/imaging/fit/fit_parts.h"

namespace limberg::imaging {

namespace {
constexpr double kStep = 0.3, kWay = 2.5;     // mean voxels: one step, and the way that is followed to either side
constexpr double kOff = 1;                    // voxels from the surface: a vertex in the mouth of a cavity is lost
constexpr double kBeyond = 0.3;               // voxels beyond the border
constexpr double kCorner = 0.5;               // radians: a surface that turns less has no crest
constexpr double kBorder = 3, kAtBorder = 2;  // voxels from the border: a rim goes to it; also one at a mouth
constexpr double kReach = 3;                  // mean voxels: how far a rim may be from the surface
}  // namespace

bool VolumeSight::lost(const Vec3& x, bool seen) const {
  const Vec3 q = to_voxel_ * (x - p_.volume.origin_mm);
  for (int k = 0; k < 3; ++k)
    if (q[k] < -kBeyond || q[k] > p_.volume.size[size_t(k)] - 1 + kBeyond) return true;
  if (p_.mouth_mm <= 0) return !seen;
  return at_gate(x) && !on_wall(x) && !std::isfinite(nearest(x, kOff * mean_voxel_));
}

bool VolumeSight::at_gate(const Vec3& x) const {
  if (p_.gate.empty()) return false;
  const Vec3 g = p_.guide.step_mm.inverse() * (x - p_.guide.origin_mm);
  int32_t at[3];
  for (int k = 0; k < 3; ++k) at[k] = std::clamp(int32_t(std::lround(g[k])), 0, p_.guide.size[size_t(k)] - 1);
  return p_.gate[p_.guide.index(at[0], at[1], at[2])] != 0;
}

/// Newton steps to the isosurface in the plane of e1 and e2.
bool VolumeSight::onto(Vec3& x, const Vec3& e1, const Vec3& e2, double within) const {
  const Vec3 from = x;
  for (int i = 0; i < 12; ++i) {
    if (!volume_.inside(x)) return false;
    const double f = volume_.value(x) - p_.iso;
    const Vec3 G = volume_.gradient(x), g = e1.dot(G) * e1 + e2.dot(G) * e2;
    if (!(g.squaredNorm() > 0)) return false;
    const Vec3 step = -f / g.squaredNorm() * g;
    const double l = step.norm();
    x += std::min(1., 0.5 * mean_voxel_ / std::max(l, 1e-12)) * step;
    if ((x - from).norm() > within) return false;
    if (l < 0.01 * mean_voxel_) return true;
  }
  return false;
}

bool VolumeSight::rim(const Vec3& x, const Vec3& along, const Vec3& N0, const Vec3& outward, Vec3& to) const {
  const Vec3 N = (N0 - along.dot(N0) * along).normalized(), c = N.cross(along);  // c: into the opening
  bool mouth = false;
  for (int i = 0; i < 3; ++i) mouth |= at_gate(x + i * mean_voxel_ * c);
  if (outward != Vec3::Zero()) {
    Vec3 there;
    double way = 0;
    const Vec3 e1 = along - outward.dot(along) * outward;
    if (border(x, kBorder * p_.voxel_mm, there, way) >= 0 && !(mouth && way > kAtBorder * p_.voxel_mm) &&
        e1.norm() > 0.1) {
      to = x + way * outward;
      if (Vec3 q = to; onto(q, e1.normalized(), outward.cross(e1).normalized(), kReach * mean_voxel_)) to = q;
      return true;
    }
  }
  if (!mouth) return false;
  Vec3 start = x;
  if (!onto(start, N, c, kReach * mean_voxel_)) {
    const PointTree::Nearest n = tree_.nearest(x, 2 * kReach * mean_voxel_);
    if (n.index < 0) return false;
    start = tree_.point(n.index);
    if (!onto(start, N, c, mean_voxel_)) {
      to = tree_.point(n.index);
      return true;
    }
  }
  // The course of the isosurface, from outside into the cavity, with the angle of its normal from c.
  const int n = int(std::ceil(kWay / kStep));
  std::vector<Vec3> place(size_t(2 * n + 1), start);
  std::vector<double> angle(size_t(2 * n + 1), 0);
  const auto normal = [&](const Vec3& p) {
    const Vec3 G = volume_.gradient(p);
    return Vec2(-c.dot(G), -N.dot(G));
  };
  const Vec2 n0 = normal(start);
  angle[size_t(n)] = elementary::atan2(n0.y(), n0.x());
  int first = n, last = n;
  for (const int way : {-1, 1}) {
    Vec3 p = start;
    for (int i = 1; i <= n; ++i) {
      const Vec2 a = normal(p);
      if (!(a.norm() > 0)) break;
      const Vec2 d = Vec2(a.y(), -a.x()).normalized() * (way * kStep * mean_voxel_);
      Vec3 q = p + d.x() * c + d.y() * N;
      if (!onto(q, N, c, mean_voxel_)) break;
      p = q;
      const size_t at = size_t(n + way * i);
      const Vec2 b = normal(p);
      place[at] = p;
      const double before = angle[size_t(int(at) - way)];
      angle[at] = before + std::remainder(elementary::atan2(b.y(), b.x()) - before, 2 * M_PI);
      (way < 0 ? first : last) = int(at);
    }
  }
  const int third = std::max(1, (last - first) / 6);
  double outer = 0, inner = 0;
  for (int i = 0; i < third; ++i) outer += angle[size_t(first + i)] / third, inner += angle[size_t(last - i)] / third;
  to = start;
  if (outer - inner < kCorner) return true;
  const double half = 0.5 * (outer + inner);
  double nearest_step = 1e300;
  for (int i = first; i < last; ++i) {
    const double a = angle[size_t(i)], b = angle[size_t(i) + 1];
    if (a < half || b > half) continue;
    const double w = a > b ? (a - half) / (a - b) : 0, at = i + w;
    if (std::abs(at - n) < nearest_step)
      nearest_step = std::abs(at - n), to = place[size_t(i)] + w * (place[size_t(i) + 1] - place[size_t(i)]);
  }
  return true;
}

}  // namespace limberg::imaging
