#include "sim/geometry/exact/predicates.h"

namespace limberg {

PredicateCounts& predicate_counts() {
  thread_local PredicateCounts counts;
  return counts;
}

int side_of_plane(const Plane& plane, const PointRef& p) {
  const Vec3& x = *p.approx;
  if (!p.implicit()) return side_of_plane(plane, Int3{int32_t(x[0]), int32_t(x[1]), int32_t(x[2])});
  if (const int s = filtered_side(plane, x); s != 0) return s;
  ++predicate_counts().side_exact;
  const Homogeneous h = p.exact();
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
  return orient2d(Projection(plane), a, b, c);
}

int orient2d(const Projection& view, const PointRef& a, const PointRef& b, const PointRef& c) {
  if (const int s = filtered_orient2d(view, *a.approx, *b.approx, *c.approx); s != 0) return s;
  const int i = view.i, j = view.j;
  if (!a.implicit() && !b.implicit() && !c.implicit()) {  // integers below 2^23: products exact in doubles
    const Vec3 &pa = *a.approx, &pb = *b.approx, &pc = *c.approx;
    const double value = (pb[i] - pa[i]) * (pc[j] - pa[j]) - (pb[j] - pa[j]) * (pc[i] - pa[i]);
    return view.facing * (value > 0 ? 1 : value < 0 ? -1 : 0);
  }
  ++predicate_counts().orient2d_exact;
  const Homogeneous ha = a.exact(), hb = b.exact(), hc = c.exact();
  const auto minor = [&](const Homogeneous& p, const Homogeneous& q) {  // x_p y_q - y_p x_q, < 2^326
    return multiply<8>(p.x[i], q.x[j]) - multiply<8>(p.x[j], q.x[i]);
  };
  const Int512 det =
      multiply<8>(minor(ha, hb), hc.w) + multiply<8>(minor(hb, hc), ha.w) + multiply<8>(minor(hc, ha), hb.w);
  return view.facing * det.sign();
}

int compare_coordinate(int axis, const PointRef& a, const PointRef& b) {
  if (!a.implicit() && !b.implicit()) {
    const double difference = (*a.approx)[axis] - (*b.approx)[axis];
    return difference > 0 ? 1 : difference < 0 ? -1 : 0;
  }
  if (const int s = filtered_order(axis, *a.approx, *b.approx); s != 0) return s;
  ++predicate_counts().order_exact;
  const Homogeneous ha = a.exact(), hb = b.exact();
  return (multiply<8>(ha.x[axis], hb.w) - multiply<8>(hb.x[axis], ha.w)).sign();
}

}  // namespace limberg
