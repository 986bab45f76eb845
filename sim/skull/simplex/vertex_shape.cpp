#include "sim/skull/simplex/vertex_shape.h"

#include <algorithm>

#include "sim/base/elementary.h"

namespace limberg::simplex {
namespace {

struct Plane {
  Vec3 N = Vec3::Zero();
  double area2 = 0, r = 0, l1 = 0, l2 = 0, l3 = 0, longest = 0;
  bool degenerate = false;
};

Plane plane(const Vec3& b, const Vec3& c) {  // b = B - A, c = C - A
  Plane p;
  const Vec3 n = b.cross(c);
  p.l1 = b.squaredNorm(), p.l2 = (c - b).squaredNorm(), p.l3 = c.squaredNorm();
  p.area2 = n.norm();
  const double most = std::max({p.l1, p.l2, p.l3});
  p.longest = std::sqrt(most);
  p.degenerate = !(p.area2 > kDegenerateTriangle * most);
  if (p.degenerate) return p;
  p.N = n / p.area2;
  p.r = std::sqrt(p.l1) * std::sqrt(p.l2) * std::sqrt(p.l3) / (2 * p.area2);
  return p;
}

double k_of(const Plane& p, double e1, double e2) {
  const double e3 = 1 - e1 - e2;
  return e1 * e2 * p.l1 + e2 * e3 * p.l2 + e3 * e1 * p.l3;
}

double height_of(const VertexShape& s, const Plane& p) {
  if (s.branch == ShapeBranch::height) return s.height * std::sqrt(p.area2);
  return height_from_angle(p.r, k_of(p, s.e1, s.e2), elementary::sin(s.phi), elementary::cos(s.phi), s.branch);
}

}  // namespace

double height_from_angle(double r, double k, double s, double c, ShapeBranch branch) {
  const double sigma = branch == ShapeBranch::far ? -1 : 1;
  const double rc = r * c, root = sigma * std::sqrt(std::max(0., rc * rc + k * s * s));
  // k s / (rc + root) = (root - rc) / s: take the one whose sum does not cancel.
  if (rc * root >= 0 && rc + root != 0) return k * s / (rc + root);
  return (root - rc) / s;
}

LocalFrame local_frame(const Vec3& P, const Vec3& A, const Vec3& B, const Vec3& C) {
  const Vec3 b = B - A, c = C - A, p = P - A;
  const Plane q = plane(b, c);
  LocalFrame f;
  f.area2_mm2 = q.area2;
  f.degenerate = q.degenerate;
  if (f.degenerate) return f;
  f.N = q.N, f.r_mm = q.r;
  f.L_mm = p.dot(q.N);
  const Vec3 foot = p - f.L_mm * q.N;
  f.e[1] = foot.cross(c).dot(q.N) / q.area2;
  f.e[2] = b.cross(foot).dot(q.N) / q.area2;
  f.e[0] = 1 - f.e[1] - f.e[2];
  f.k_mm2 = k_of(q, f.e[0], f.e[1]);
  const double y = 2 * f.r_mm * f.L_mm, x = f.k_mm2 - f.L_mm * f.L_mm, h = elementary::hypot(x, y);
  if (h > 0) f.sin_phi = y / h, f.cos_phi = x / h;  // (h = 0: P is on the circumcircle, the angle is free)
  return f;
}

VertexShape encode(const Vec3& P, const Vec3& A, const Vec3& B, const Vec3& C, ShapeCode code) {
  VertexShape s;
  const Plane q = plane(B - A, C - A);
  if (q.degenerate) return s;
  const LocalFrame f = local_frame(P, A, B, C);
  s.e1 = f.e[0], s.e2 = f.e[1];
  s.phi = f.phi();
  s.height = f.L_mm / std::sqrt(f.area2_mm2);
  if (code == ShapeCode::angle) {
    s.branch = f.far_branch() ? ShapeBranch::far : ShapeBranch::near;
    constexpr double kGivenBack = 2e-14;  // of the vertex's size: some ten roundings
    if (std::abs(height_of(s, q) - f.L_mm) <= kGivenBack * std::max(q.longest, std::abs(f.L_mm))) return s;
  }
  s.branch = ShapeBranch::height;
  return s;
}

Vec3 decode(const VertexShape& s, const Vec3& A, const Vec3& B, const Vec3& C) {
  const Vec3 b = B - A, c = C - A;
  const Plane q = plane(b, c);
  const Vec3 foot = s.e2 * b + (1 - s.e1 - s.e2) * c;
  if (q.degenerate) return A + foot;
  return A + (foot + height_of(s, q) * q.N);
}

}  // namespace limberg::simplex
