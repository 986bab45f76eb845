#include "app/assembly/cut_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

Vec3 foot_on(const std::vector<Vec3>& ring, const Vec3& p) {
  Vec3 best = ring[0];
  for (size_t i = 0; i < ring.size(); ++i) {
    const Vec3 &a = ring[i], e = ring[(i + 1) % ring.size()] - a;
    const Vec3 q = a + std::clamp((p - a).dot(e) / std::max(1e-12, e.squaredNorm()), 0.0, 1.0) * e;
    if ((p - q).norm() < (p - best).norm()) best = q;
  }
  return best;
}

/// A ring by hand is spanned by the cut, about as a fan about its middle does: what lies within it is near, too.
double near_ring_mm(const std::vector<Vec3>& ring, const Vec3& p) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& q : ring) middle += q / double(ring.size());
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < ring.size(); ++i)
    least = std::min(least, (closest_on_triangle(p, middle, ring[i], ring[(i + 1) % ring.size()]).point - p).norm());
  return least;
}

}  // namespace

std::optional<std::pair<Vec3, Vec3>> SawPlane::through(const std::array<Vec3, 3>& x) const {
  std::array<Vec3, 3> ends;
  size_t n = 0;
  for (size_t k = 0; k < 3; ++k) {
    const Vec3 &p = x[k], &q = x[(k + 1) % 3];
    const double hp = (p - at).dot(normal), hq = (q - at).dot(normal);
    if ((hp < 0) != (hq < 0)) ends[n++] = p + (q - p) * (hp / (hp - hq));
  }
  if (n != 2) return std::nullopt;
  return std::pair(ends[0], ends[1]);
}

std::vector<SawPlane> planes_of(const HeadCommand& c) {
  std::vector<SawPlane> all;
  if (const auto* cut = std::get_if<CutBone>(&c); cut && cut->contour_mm.empty())
    all.push_back({cut->point_mm, cut->normal.normalized(), Vec3::Zero(), Vec3::Zero(), cut->radius_mm});
  if (const auto* blade = std::get_if<CutBoneByBlade>(&c))
    for (size_t i = 0; i + 1 < blade->rays.size(); ++i) {
      const Vec3 n = blade->rays[i].cross(blade->rays[i + 1]);
      if (n.norm() > 1e-9)
        all.push_back({blade->corner_mm, n.normalized(), blade->rays[i], blade->rays[i + 1], blade->reach_mm});
    }
  return all;
}

const SawPlane* nearest_plane(const std::vector<SawPlane>& planes, const Vec3& p) {
  const SawPlane* best = nullptr;
  for (const SawPlane& k : planes)
    if (k.reaches(p) && (!best || std::abs((p - k.at).dot(k.normal)) < std::abs((p - best->at).dot(best->normal))))
      best = &k;
  return best;
}

std::optional<Vec3> beside_cut(const HeadCommand& planned, const Vec3& p) {
  if (const auto* cut = std::get_if<CutBone>(&planned); cut && !cut->contour_mm.empty())
    return p - foot_on(cut->contour_mm, p);
  const std::vector<SawPlane> planes = planes_of(planned);
  const SawPlane* k = nearest_plane(planes, p);
  if (!k) return std::nullopt;
  return Vec3((p - k->at).dot(k->normal) * k->normal);
}

std::optional<double> nearest_to_limit_mm(const SafeLimit& l, const HeadCommand& cut) {
  if (l.bone_line.empty()) return std::nullopt;
  std::optional<double> nearest;
  for (size_t i = 0; i + 1 < l.bone_line.size(); ++i) {
    constexpr int kSamples = 20;
    for (int k = 0; k <= kSamples; ++k) {
      const Vec3 p = l.bone_line[i] + (l.bone_line[i + 1] - l.bone_line[i]) * (double(k) / kSamples);
      const auto off = beside_cut(cut, p);
      if (!off) continue;
      const auto* ring = std::get_if<CutBone>(&cut);
      const double mm = ring && !ring->contour_mm.empty() ? near_ring_mm(ring->contour_mm, p) : off->norm();
      nearest = std::min(nearest.value_or(mm), mm);
    }
  }
  return nearest;
}

}  // namespace limberg
