#pragma once
// Signs that decide topology. Each is exact: a double filter with a proven error bound first, wide integers when it
// cannot tell. Half-units, |coordinate| < 2^21.
//
//   explicit determinants      69 bits   __int128
//   plane side of a TPI       209 bits   Int256
//   order of two TPIs         301 bits   Int512
//   orient2d of three TPIs    465 bits   Int512
//
// What is decided by doubles or by 128 bits stands here, to be inlined: a cut asks ten thousands of times.
#include <cmath>

#include "sim/geometry/exact/point.h"

namespace limberg {

/// A point as predicates see it: its double approximation, and its
/// exact form. Explicit points have no other: their doubles are exact.
struct PointRef {
  const Vec3* approx = nullptr;
  const NarrowHomogeneous* line_plane = nullptr;  // of an LPI
  const Homogeneous* three_planes = nullptr;      // of a TPI
  bool implicit() const { return line_plane || three_planes; }
  Homogeneous exact() const {
    if (line_plane) return widened(*line_plane);
    return three_planes ? *three_planes
                        : homogeneous({int32_t((*approx)[0]), int32_t((*approx)[1]), int32_t((*approx)[2])});
  }
};

/// Sign of (b - a) x (c - a) . (d - a): +1 when d is on the positive side of the plane a, b, c.
inline int orient3d(const Int3& a, const Int3& b, const Int3& c, const Int3& d) {
  const int64_t ux = int64_t(b.x) - a.x, uy = int64_t(b.y) - a.y, uz = int64_t(b.z) - a.z;
  const int64_t vx = int64_t(c.x) - a.x, vy = int64_t(c.y) - a.y, vz = int64_t(c.z) - a.z;
  const int64_t wx = int64_t(d.x) - a.x, wy = int64_t(d.y) - a.y, wz = int64_t(d.z) - a.z;
  return sign_of(int128(uy * vz - uz * vy) * wx + int128(uz * vx - ux * vz) * wy + int128(ux * vy - uy * vx) * wz);
}

/// Sign of n . p - d.
inline int side_of_plane(const Plane& plane, const Int3& p) {
  return sign_of(int128(plane.n[0]) * p.x + int128(plane.n[1]) * p.y + int128(plane.n[2]) * p.z - plane.d);
}
int side_of_plane(const Plane& plane, const PointRef& p);

/// The coordinate axis to drop when projecting a plane: that of the largest normal component.
int projection_axis(const Plane& plane);

/// Orientation of a, b, c, all on `plane`, seen from its positive side: +1 counter-clockwise.
int orient2d(const Plane& plane, const PointRef& a, const PointRef& b, const PointRef& c);

/// How a plane is looked at by orient2d: the two axes that stay, and +1 when they show its positive side.
struct Projection {
  int i = 0, j = 1, facing = 1;
  Projection() = default;
  explicit Projection(const Plane& plane) {
    const int drop = projection_axis(plane);
    i = (drop + 1) % 3, j = (drop + 2) % 3;
    facing = plane.n[size_t(drop)] > 0 ? 1 : -1;
  }
};
int orient2d(const Projection& view, const PointRef& a, const PointRef& b, const PointRef& c);

/// Sign of (coordinate of a) - (coordinate of b) along an axis.
int compare_coordinate(int axis, const PointRef& a, const PointRef& b);

// The filters alone: the sign by doubles, or 0 when they cannot tell. Points by their approximations; explicit ones are
// taken as if they had an error too.
int filtered_side(const Plane& plane, const Vec3& p);
int filtered_orient2d(const Projection& view, const Vec3& a, const Vec3& b, const Vec3& c);
int filtered_order(int axis, const Vec3& a, const Vec3& b);

/// How often the wide integers were needed, for benchmarks. Per thread.
struct PredicateCounts {
  uint64_t side_exact = 0, orient2d_exact = 0, order_exact = 0;
};
PredicateCounts& predicate_counts();

inline int filtered_side(const Plane& plane, const Vec3& p) {
  // The normal is exact in doubles (45 bits). Errors: the point (kApproximationError per coordinate times the normal),
  // the rounding of d (68 bits) and of three products and sums, each below 2^-50 of the largest term.
  const double* x = p.data();
  const double n0 = double(plane.n[0]), n1 = double(plane.n[1]), n2 = double(plane.n[2]);
  const double d = double(int64_t(plane.d >> 32)) * 0x1p32 + double(uint32_t(plane.d));
  const double t0 = n0 * x[0], t1 = n1 * x[1], t2 = n2 * x[2];
  const double value = t0 + t1 + t2 - d;
  const double bound = (std::abs(n0) + std::abs(n1) + std::abs(n2)) * (2 * kApproximationError) +
                       (std::abs(t0) + std::abs(t1) + std::abs(t2) + std::abs(d)) * 0x1p-50;
  return int(value > bound) - int(value < -bound);
}

inline int filtered_orient2d(const Projection& view, const Vec3& a, const Vec3& b, const Vec3& c) {
  const double *pa = a.data(), *pb = b.data(), *pc = c.data();
  const int i = view.i, j = view.j;
  const double ux = pb[i] - pa[i], uy = pb[j] - pa[j], vx = pc[i] - pa[i], vy = pc[j] - pa[j];
  const double left = ux * vy, right = uy * vx, value = left - right;
  // Each difference carries at most 2 kApproximationError (plus rounding, far below); products and their difference
  // add a few units of 2^-53 of their size.
  constexpr double e = 4 * kApproximationError;
  const double bound = e * (std::abs(ux) + std::abs(uy) + std::abs(vx) + std::abs(vy) + e) +
                       (std::abs(left) + std::abs(right)) * 0x1p-50;
  return view.facing * (int(value > bound) - int(value < -bound));
}

inline int filtered_order(int axis, const Vec3& a, const Vec3& b) {
  const double difference = a.data()[axis] - b.data()[axis];
  return int(difference > 4 * kApproximationError) - int(difference < -4 * kApproximationError);
}

}  // namespace limberg
