#include "sim/geometry/exact/point.h"

namespace limberg {

namespace {

std::array<int64_t, 3> difference(const Int3& a, const Int3& b) {
  return {int64_t(a.x) - b.x, int64_t(a.y) - b.y, int64_t(a.z) - b.z};
}

// Cross product of two normals (< 2^45 each): components < 2^91.
std::array<int128, 3> cross(const std::array<int64_t, 3>& a, const std::array<int64_t, 3>& b) {
  return {int128(a[1]) * b[2] - int128(a[2]) * b[1], int128(a[2]) * b[0] - int128(a[0]) * b[2],
          int128(a[0]) * b[1] - int128(a[1]) * b[0]};
}

}  // namespace

Plane plane_through(const Int3& a, const Int3& b, const Int3& c) {
  const auto u = difference(b, a), v = difference(c, a);
  Plane p;
  p.n = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  p.d = int128(p.n[0]) * a.x + int128(p.n[1]) * a.y + int128(p.n[2]) * a.z;
  return p;
}

NarrowHomogeneous line_plane(const Int3& p, const Int3& q, const Plane& plane) {
  const auto u = difference(q, p);
  int128 w = 0, t = plane.d;  // the point is p + (t/w) (q - p)
  const std::array<int64_t, 3> from{p.x, p.y, p.z};
  for (int i = 0; i < 3; ++i) {
    w += int128(plane.n[i]) * u[i];
    t -= int128(plane.n[i]) * from[i];
  }
  if (w < 0) w = -w, t = -t;
  NarrowHomogeneous h;
  for (size_t i = 0; i < 3; ++i) h.x[i] = w * from[i] + t * u[i];
  h.w = w;
  return h;
}

Homogeneous three_planes(const Plane& a, const Plane& b, const Plane& c) {
  // Cramer: x = (d_a (n_b x n_c) + d_b (n_c x n_a) + d_c (n_a x n_b)) / det.
  const auto bc = cross(b.n, c.n), ca = cross(c.n, a.n), ab = cross(a.n, b.n);
  Homogeneous h;
  h.w = Int256(int64_t(0));
  for (int i = 0; i < 3; ++i) {
    const auto term = [](int128 l, int128 r) { return multiply<4>(WideInt<2>(l), WideInt<2>(r)); };
    h.w += term(bc[i], a.n[i]);
    h.x[i] = term(a.d, bc[i]) + term(b.d, ca[i]) + term(c.d, ab[i]);
  }
  if (h.w.negative()) {
    h.w = -h.w;
    for (auto& x : h.x) x = -x;
  }
  return h;
}

Homogeneous homogeneous(const Int3& p) {
  Homogeneous h;
  h.x = {Int256(int64_t(p.x)), Int256(int64_t(p.y)), Int256(int64_t(p.z))};
  return h;
}

Vec3 approximate(const Homogeneous& p) {
  const double w = p.w.to_double();
  return {p.x[0].to_double() / w, p.x[1].to_double() / w, p.x[2].to_double() / w};
}

Vec3 approximate(const NarrowHomogeneous& p) {
  const double w = WideInt<2>(p.w).to_double();
  return {WideInt<2>(p.x[0]).to_double() / w, WideInt<2>(p.x[1]).to_double() / w, WideInt<2>(p.x[2]).to_double() / w};
}

}  // namespace limberg
