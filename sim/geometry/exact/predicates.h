#pragma once
// Signs that decide topology. Each is exact: a double filter with a proven error bound first, wide integers when it
// cannot tell. Half-units, |coordinate| < 2^21.
//
//   explicit determinants      69 bits   __int128
//   plane side of a TPI       209 bits   Int256
//   order of two TPIs         301 bits   Int512
//   orient2d of three TPIs    465 bits   Int512
#include "sim/geometry/exact/point.h"

namespace limberg {

/// A point as predicates see it: its double approximation, and its exact form. `implicit` is null for explicit points,
/// whose doubles are exact.
struct PointRef {
  const Vec3* approx = nullptr;
  const Homogeneous* implicit = nullptr;
};

/// Sign of (b - a) x (c - a) . (d - a): +1 when d is on the positive side of the plane a, b, c.
int orient3d(const Int3& a, const Int3& b, const Int3& c, const Int3& d);

/// Sign of n . p - d.
int side_of_plane(const Plane& plane, const Int3& p);
int side_of_plane(const Plane& plane, const PointRef& p);

/// The coordinate axis to drop when projecting a plane: that of the largest normal component.
int projection_axis(const Plane& plane);

/// Orientation of a, b, c, all on `plane`, seen from its positive side: +1 counter-clockwise.
int orient2d(const Plane& plane, const PointRef& a, const PointRef& b, const PointRef& c);

/// Sign of (coordinate of a) - (coordinate of b) along an axis.
int compare_coordinate(int axis, const PointRef& a, const PointRef& b);

/// How often the wide integers were needed, for benchmarks. Per thread.
struct PredicateCounts {
  uint64_t side_exact = 0, orient2d_exact = 0, order_exact = 0;
};
PredicateCounts& predicate_counts();

}  // namespace limberg
