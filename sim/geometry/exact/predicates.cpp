#include "sim/geometry/exact/predicates.h"

#include <cmath>

namespace limberg {

PredicateCounts& predicate_counts() {
  thread_local PredicateCounts counts;
  return counts;
}

namespace {

Homogeneous exact_form(const PointRef& p) {
  if (p.implicit) return *p.implicit;
  return homogeneous({int32_t((*p.approx)[0]), int32_t((*p.approx)[1]), int32_t((*p.approx)[2])});
}

}  // namespace

int orient3d(const Int3& a, const Int3& b, const Int3& c, const Int3& d) {
  const int64_t ux = int64_t(b.x) - a.x, uy = int64_t(b.y) - a.y, uz = int64_t(b.z) - a.z;
  const int64_t vx = int64_t(c.x) - a.x, vy = int64_t(c.y) - a.y, vz = int64_t(c.z) - a.z;
  const int64_t wx = int64_t(d.x) - a.x, wy = int64_t(d.y) - a.y, wz = int64_t(d.z) - a.z;
  return sign_of(int128(uy * vz - uz * vy) * wx + int128(uz * vx - ux * vz) * wy + int128(ux * vy - uy * vx) * wz);
}

int side_of_plane(const Plane& plane, const Int3& p) {
  return sign_of(int128(plane.n[0]) * p.x + int128(plane.n[1]) * p.y + int128(plane.n[2]) * p.z - plane.d);
}

int side_of_plane(const Plane& plane, const PointRef& p) {
  const Vec3& x = *p.approx;
  if (!p.implicit) return side_of_plane(plane, Int3{int32_t(x[0]), int32_t(x[1]), int32_t(x[2])});
  // Filter. The normal is exact in doubles (45 bits). Errors: the point (kApproximationError per coordinate times the
  // normal), the rounding of d (68 bits) and of three products and sums, each below 2^-50 of the largest term.
  const double n0 = double(plane.n[0]), n1 = double(plane.n[1]), n2 = double(plane.n[2]), d = double(plane.d);
  const double t0 = n0 * x[0], t1 = n1 * x[1], t2 = n2 * x[2];
  const double value = t0 + t1 + t2 - d;
  const double bound = (std::abs(n0) + std::abs(n1) + std::abs(n2)) * (2 * kApproximationError) +
                       (std::abs(t0) + std::abs(t1) + std::abs(t2) + std::abs(d)) * 0x1p-50;
  if (value > bound) return 1;
  if (value < -bound) return -1;
  ++predicate_counts().side_exact;
  const Homogeneous& h = *p.implicit;
  Int256 s = -multiply<4>(WideInt<2>(plane.d), h.w);
  for (int i = 0; i < 3; ++i) s += multiply<4>(WideInt<1>(plane.n[i]), h.x[i]);
  return s.sign();
}

int projection_axis(const Plane& plane) {
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(plane.n[i]) > std::abs(plane.n[axis])) axis = i;
  return axis;
}

int orient2d(const Plane& plane, const PointRef& a, const PointRef& b, const PointRef& c) {
  const int drop = projection_axis(plane);
  const int i = (drop + 1) % 3, j = (drop + 2) % 3;
  const int facing = plane.n[drop] > 0 ? 1 : -1;
  const Vec3 &pa = *a.approx, &pb = *b.approx, &pc = *c.approx;
  const double ux = pb[i] - pa[i], uy = pb[j] - pa[j], vx = pc[i] - pa[i], vy = pc[j] - pa[j];
  const double left = ux * vy, right = uy * vx, value = left - right;
  // Each difference carries at most 2 kApproximationError (plus rounding, far below); products and their difference
  // add a few units of 2^-53 of their size.
  constexpr double e = 4 * kApproximationError;
  const double bound = e * (std::abs(ux) + std::abs(uy) + std::abs(vx) + std::abs(vy) + e) +
                       (std::abs(left) + std::abs(right)) * 0x1p-50;
  if (value > bound) return facing;
  if (value < -bound) return -facing;
  if (!a.implicit && !b.implicit && !c.implicit) {  // integers below 2^23: products exact in doubles
    return facing * (value > 0 ? 1 : value < 0 ? -1 : 0);
  }
  ++predicate_counts().orient2d_exact;
  const Homogeneous ha = exact_form(a), hb = exact_form(b), hc = exact_form(c);
  const auto minor = [&](const Homogeneous& p, const Homogeneous& q) {  // x_p y_q - y_p x_q, < 2^326
    return multiply<8>(p.x[i], q.x[j]) - multiply<8>(p.x[j], q.x[i]);
  };
  const Int512 det =
      multiply<8>(minor(ha, hb), hc.w) + multiply<8>(minor(hb, hc), ha.w) + multiply<8>(minor(hc, ha), hb.w);
  return facing * det.sign();
}

int compare_coordinate(int axis, const PointRef& a, const PointRef& b) {
  const double difference = (*a.approx)[axis] - (*b.approx)[axis];
  if (!a.implicit && !b.implicit) return difference > 0 ? 1 : difference < 0 ? -1 : 0;
  if (difference > 4 * kApproximationError) return 1;
  if (difference < -4 * kApproximationError) return -1;
  ++predicate_counts().order_exact;
  const Homogeneous ha = exact_form(a), hb = exact_form(b);
  return (multiply<8>(ha.x[axis], hb.w) - multiply<8>(hb.x[axis], ha.w)).sign();
}

}  // namespace limberg
