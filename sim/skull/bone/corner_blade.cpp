#include "sim/skull/bone/corner_blade.h"

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/base/text.h"
#include "sim/commands/head_command.h"
#include "sim/geometry/triangle.h"

namespace limberg::bone {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kLeastSector = 5 * kDegree, kMostSector = 150 * kDegree;
constexpr double kTouch = 1e-6;  // sine of the angle at which a direction still counts as within a sector

/// A direction between a and b, or on one of them.
bool within(const Vec3& d, const Vec3& a, const Vec3& b) {
  const Vec3 n = a.cross(b).normalized();
  return std::abs(n.dot(d)) <= kTouch && n.cross(a).dot(d) >= -kTouch && b.cross(n).dot(d) >= -kTouch;
}

/// Whether two sectors have more in common than the corner and, of neighbours, the ray between them. Cones with one
/// apex meet where their planes do: along one line; in one plane, where one has a side of the other within.
bool meet(const std::vector<Vec3>& ray, size_t i, size_t j) {
  const Vec3 n = ray[i].cross(ray[i + 1]).normalized(), m = ray[j].cross(ray[j + 1]).normalized();
  const bool neighbours = j == i + 1;
  const Vec3 line = n.cross(m);
  if (line.norm() > kTouch) {
    if (neighbours) return false;
    for (const double s : {1., -1.}) {
      const Vec3 d = s * line.normalized();
      if (within(d, ray[i], ray[i + 1]) && within(d, ray[j], ray[j + 1])) return true;
    }
    return false;
  }
  // In one plane. Neighbours go on from their common ray, or fold back upon each other.
  if (neighbours) return n.dot(m) < 0;
  return within(ray[j], ray[i], ray[i + 1]) || within(ray[j + 1], ray[i], ray[i + 1]) ||
         within(ray[i], ray[j], ray[j + 1]) || within(ray[i + 1], ray[j], ray[j + 1]);
}

}  // namespace

CornerBlade::CornerBlade(const Vec3& corner, const std::vector<Vec3>& rays, double reach_mm) {
  if (!corner.allFinite() || !(reach_mm > 0) || !std::isfinite(reach_mm)) {
    fault_ = "a blade has a corner at a finite place and a length above 0";
    return;
  }
  if (rays.size() < 2 || rays.size() > kMostBladeRays) {
    fault_ = "a blade of planes that meet in a corner has two to eight directions";
    return;
  }
  X_mm_.push_back(corner);
  for (const Vec3& r : rays) {
    if (!r.allFinite() || !(r.norm() > 1e-9)) {
      fault_ = "a direction of the blade is not finite or has no length";
      return;
    }
    ray_.push_back(r.normalized());
    X_mm_.push_back(corner + reach_mm * ray_.back());
  }
  angle_.push_back(0);
  for (size_t k = 0; k + 1 < ray_.size(); ++k) {
    const Vec3 n = ray_[k].cross(ray_[k + 1]);
    const double a = elementary::atan2(n.norm(), ray_[k].dot(ray_[k + 1]));
    if (!(a >= kLeastSector && a <= kMostSector)) {
      fault_ = "two directions of the blade that follow each other lie at less than 5 or more than 150 degrees";
      return;
    }
    normal_.push_back(n.normalized());
    angle_.push_back(angle_.back() + a);
    X_mm_.push_back(corner + reach_mm * (ray_[k] + ray_[k + 1]));
    const auto a0 = int32_t(k + 1), b0 = a0 + 1, far = int32_t(X_mm_.size() - 1);
    tri_.push_back({0, a0, far}), tri_.push_back({0, far, b0});
  }
  for (size_t j = 1; j < sectors(); ++j)
    for (size_t i = 0; i < j; ++i)
      if (meet(ray_, i, j)) {
        fault_ = text(
            "plane %d of the blade crosses or touches plane %d; expected planes that meet at the corner and "
            "along one ray after the other",
            int(j + 1), int(i + 1));
        return;
      }
  if (angle_.back() > 2 * M_PI - kLeastSector) fault_ = "the planes of the blade take up a full turn about its corner";
}

double CornerBlade::apart2(size_t s, const Vec3& x) const {
  const Vec3 d = x - X_mm_[0], &n = normal_[s];
  const Vec3 flat = d - n.dot(d) * n;
  // Beyond a ray: as far as from the ray.
  const double before = n.cross(ray_[s]).dot(flat), after = ray_[s + 1].cross(n).dot(flat);
  if (before >= 0 && after >= 0) return n.dot(d) * n.dot(d);
  const auto from_ray = [&](const Vec3& r) { return (d - std::max(0., r.dot(d)) * r).squaredNorm(); };
  return std::min(from_ray(ray_[s]), from_ray(ray_[s + 1]));
}

size_t CornerBlade::sector(const Vec3& x) const {
  size_t best = 0;
  for (size_t s = 1; s < sectors(); ++s)
    if (apart2(s, x) < apart2(best, x)) best = s;
  return best;
}

Vec2 CornerBlade::unrolled(const Vec3& x) const {
  const size_t s = sector(x);
  const Vec3 d = x - X_mm_[0];
  const double u = ray_[s].dot(d), v = normal_[s].cross(ray_[s]).dot(d);
  const double c = elementary::cos(angle_[s]), w = elementary::sin(angle_[s]);
  return {c * u - w * v, w * u + c * v};
}

double CornerBlade::past_fold(size_t k, const Vec3& x) const {
  const Vec3 across = normal_[k].cross(ray_[k]) + normal_[k - 1].cross(ray_[k]);  // both point onwards
  return across.normalized().dot(x - X_mm_[0]);
}

double CornerBlade::along_fold(size_t k, const Vec3& x) const { return ray_[k].dot(x - X_mm_[0]); }

}  // namespace limberg::bone
