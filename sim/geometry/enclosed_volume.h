#pragma once
#include <span>
#include <utility>

#include "sim/geometry/tri_mesh.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// Of a closed surface, in the cube of the points' unit: above 0 where its triangles run counter-clockwise seen from
/// outside. Summed about its first corner: the theorem of Gauss, one tetrahedron for each triangle.
inline double enclosed_volume(std::span<const Vec3> points, std::span<const Tri> triangles) {
  if (triangles.empty()) return 0;
  const Vec3& about = points[size_t(triangles[0][0])];
  double six = 0;
  for (const Tri& t : triangles) {
    const Vec3 a = points[size_t(t[0])] - about, b = points[size_t(t[1])] - about, c = points[size_t(t[2])] - about;
    six += a.dot(b.cross(c));
  }
  return six / 6;
}

/// Programs that mirror a mesh leave it inside out: a closed surface has but one outside. True: it was turned.
inline bool turn_outwards(TriMesh& m) {
  if (!(enclosed_volume(m.X_mm, m.tri) < 0)) return false;
  for (Tri& t : m.tri) std::swap(t[1], t[2]);
  for (auto& uv : m.uv) std::swap(uv[1], uv[2]);
  return true;
}

}  // namespace limberg
