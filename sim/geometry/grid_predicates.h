#pragma once
// Exact predicates on explicit points of the rest grid. With |coordinate| < 2^21 a difference takes 22 bits, a cross
// product 45 and a volume 69, so 128-bit integers hold everything and no result is ever rounded.
#include <array>
#include <cstdint>

#include "sim/geometry/vec.h"

namespace limberg {

__extension__ typedef __int128 GridVolume;  // 6 times a volume in half-units cubed

/// Twice the area times the normal of abc.
inline std::array<int64_t, 3> grid_normal(const Int3& a, const Int3& b, const Int3& c) {
  const int64_t ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z, vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
  return {uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx};
}

/// 6 times the signed volume of the tetrahedron abcd: positive
/// when d lies on the side that the normal of abc points to.
inline GridVolume grid_orient3d(const Int3& a, const Int3& b, const Int3& c, const Int3& d) {
  const auto n = grid_normal(a, b, c);
  return GridVolume(n[0]) * (d.x - a.x) + GridVolume(n[1]) * (d.y - a.y) + GridVolume(n[2]) * (d.z - a.z);
}

using GridTriangle = std::array<Int3, 3>;

/// Whether segment pq and triangle t, both closed, have a point in common. t must have an area.
bool grid_segment_meets_triangle(const Int3& p, const Int3& q, const GridTriangle& t);

/// Whether two triangles of a mesh have more in common than the corners that are equal points in both. Both must have
/// an area. Sharing one corner or one edge is allowed; touching elsewhere, crossing and overlapping are not.
bool grid_triangles_offend(const GridTriangle& a, const GridTriangle& b);

}  // namespace limberg
