#pragma once
// Points and planes of the exact rest space. All numbers are half-units of the rest grid (sim/geometry/rest_grid.h).
//
// A point is one of three kinds, and never anything else, so precision does not grow with the number of cuts:
//   explicit  an integer point: a vertex of the body or of a blade
//   LPI       line x plane: an edge of an original triangle meets another original triangle
//   TPI       three planes: three original triangles meet
// The implicit kinds are kept in homogeneous coordinates (x/w, y/w, z/w) with w > 0.
//
// Bit budgets for |coordinate| < 2^21 (checked by tests/sim/cutting/test_exact.cpp with extreme coordinates):
//   plane normal < 2^45, plane offset < 2^68, LPI w < 2^69, LPI x < 2^92, TPI w < 2^138, TPI x < 2^162
#include "sim/geometry/exact/wide_int.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// The oriented plane n . x = d through an original triangle; n = (b - a) x (c - a), so positive is where a, b, c turn
/// counter-clockwise.
struct Plane {
  std::array<int64_t, 3> n{};
  int128 d = 0;
};

/// An implicit point in homogeneous coordinates, w > 0.
struct Homogeneous {
  std::array<Int256, 3> x{};
  Int256 w{int64_t(1)};
};

/// The same of an LPI, for which 128 bits are enough: most implicit points are of this kind.
struct NarrowHomogeneous {
  std::array<int128, 3> x{};
  int128 w = 1;
};
inline Homogeneous widened(const NarrowHomogeneous& p) {
  return {{Int256(p.x[0]), Int256(p.x[1]), Int256(p.x[2])}, Int256(p.w)};
}

Plane plane_through(const Int3& a, const Int3& b, const Int3& c);

/// Where the line through p and q meets the plane. The line must not be parallel to it.
NarrowHomogeneous line_plane(const Int3& p, const Int3& q, const Plane& plane);

/// Where three planes meet. Their normals must be independent.
Homogeneous three_planes(const Plane& a, const Plane& b, const Plane& c);

Homogeneous homogeneous(const Int3& p);

/// Coordinates as doubles; absolute error at most kApproximationError.
Vec3 approximate(const Homogeneous& p);
Vec3 approximate(const NarrowHomogeneous& p);

/// Each of x and w is rounded with relative error 2^-52, then divided: 2^21 * 2.5 * 2^-52 < 2^-29.
inline constexpr double kApproximationError = 1.0 / (1 << 29);

}  // namespace limberg
