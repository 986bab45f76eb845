#include "sim/geometry/sided_patch.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "sim/base/elementary.h"
#include "sim/geometry/triangle.h"

namespace limberg {

Vec3 face_normal(const TriMesh& m, int32_t t) {
  const Tri& c = m.tri[size_t(t)];
  return area_vector2(m.X_mm[size_t(c[0])], m.X_mm[size_t(c[1])], m.X_mm[size_t(c[2])]).normalized();
}

SidedPatch::SidedPatch(const TriMesh& mesh) {
  std::vector<int32_t> all(mesh.tri.size());
  std::iota(all.begin(), all.end(), 0);
  *this = SidedPatch(mesh, all);
}

SidedPatch::SidedPatch(const TriMesh& mesh, std::span<const int32_t> of) : mesh_(&mesh), bvh_(mesh.X_mm, mesh.tri, of) {
  const TriMesh& m = mesh;
  corner_normal_.assign(m.X_mm.size(), Vec3::Zero());
  edge_normal_.assign(m.tri.size(), {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()});
  struct Side {
    int32_t a, b, triangle;
    int k;
  };
  std::vector<Side> sides;
  sides.reserve(3 * of.size());
  for (int32_t t : of) {
    const Tri& c = m.tri[size_t(t)];
    const Vec3 n = face_normal(m, t);
    for (int k = 0; k < 3; ++k) {
      const int32_t v = c[size_t(k)], next = c[size_t((k + 1) % 3)], last = c[size_t((k + 2) % 3)];
      const Vec3 e = m.X_mm[size_t(next)] - m.X_mm[size_t(v)], f = m.X_mm[size_t(last)] - m.X_mm[size_t(v)];
      corner_normal_[size_t(v)] += elementary::atan2(e.cross(f).norm(), e.dot(f)) * n;
      sides.push_back({std::min(v, next), std::max(v, next), t, k});
    }
  }
  for (Vec3& n : corner_normal_)
    if (n.squaredNorm() > 0) n.normalize();
  std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
    return std::tie(p.a, p.b, p.triangle) < std::tie(q.a, q.b, q.triangle);
  });
  for (size_t i = 0; i < sides.size();) {
    size_t j = i;
    Vec3 sum = Vec3::Zero();
    for (; j < sides.size() && sides[j].a == sides[i].a && sides[j].b == sides[i].b; ++j)
      sum += face_normal(m, sides[j].triangle);
    for (; i < j; ++i) edge_normal_[size_t(sides[i].triangle)][size_t(sides[i].k)] = sum;
  }
}

Vec3 SidedPatch::side_normal(const Bvh::Closest& c) const {
  const Tri& t = mesh_->tri[size_t(c.triangle)];
  const int zeros = int(c.bary[0] == 0) + int(c.bary[1] == 0) + int(c.bary[2] == 0);
  if (zeros == 2)
    for (size_t k = 0; k < 3; ++k)
      if (c.bary[k] != 0) return corner_normal_[size_t(t[k])];
  if (zeros == 1)
    for (size_t k = 0; k < 3; ++k)
      if (c.bary[k] == 0) return edge_normal_[size_t(c.triangle)][(k + 1) % 3];
  return face_normal(*mesh_, c.triangle);
}

void SidedPatch::find(const Vec3& X, Bvh::Closest& near) const {
  // The last answer's point is on the patch too: nothing farther away can be nearest.
  const double bound =
      near.triangle >= 0 ? (X - near.point_mm).norm() * (1 + 1e-12) + 1e-12 : std::numeric_limits<double>::infinity();
  near = bvh_.closest(X, bound);
}

double SidedPatch::depth_mm(const Vec3& X, Bvh::Closest& near) const {
  find(X, near);
  return (X - near.point_mm).dot(side_normal(near)) > 0 ? -near.distance_mm : near.distance_mm;
}

double SidedPatch::depth_of_plane_mm(const Vec3& X, Bvh::Closest& near) const {
  find(X, near);
  const Vec3 n = side_normal(near);
  return n.squaredNorm() > 0 ? (near.point_mm - X).dot(n.normalized()) : near.distance_mm;
}

}  // namespace limberg
