#pragma once
// Bones for the tests: a skull shell that is one closed surface (the outer table turns into the inner one at the
// foramen), a solid ellipsoid, a bent tube like a mandible.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"

namespace limberg::test {

/// Outer and inner table as scaled spheres, joined at the foramen
/// (below, z near -0.93 of the outer radius). `uneven`: with bosses
/// and hollows of that height, no two alike, and a thickness that
/// varies by a third of it, as skulls have them. `turn`: of the
/// mesh on the same shape, so that it is divided into other faces.
inline simplex::Mesh skull_shell(int levels = 4, const Vec3& half_mm = {70, 85, 65}, double thick_mm = 6,
                                 double uneven_mm = 0, const Mat3& turn = Mat3::Identity()) {
  using namespace simplex;
  Mesh m = make_sphere({0, 0, 0}, 1, levels);
  for (Vec3& x : m.x_mm) x = turn * x;
  Mesh inner = m;
  const auto boss = [](const Vec3& u, double phase) {
    return 0.5 * std::sin(5.3 * u.x() + 2.1 * u.y() + phase) +
           0.5 * std::sin(4.1 * u.y() - 3.7 * u.z() + 1 + 2 * phase) + 0.5 * std::sin(6.1 * u.z() + 3.3 * u.x() + 2);
  };
  for (Vec3& x : m.x_mm) x = x.cwiseProduct(half_mm) + uneven_mm * boss(x, 0) * x;
  for (Vec3& x : inner.x_mm)
    x = x.cwiseProduct(half_mm - Vec3::Constant(thick_mm)) + uneven_mm * (boss(x, 0) + boss(x, 0.7) / 3) * x;
  for (Row& r : inner.nbr) std::swap(r[1], r[2]);
  m.before_mm = m.x_mm;
  append(m, make_mesh(inner.nbr, inner.x_mm));
  Delta d;
  std::vector<simplex::OperatorResult> mouths;
  for (const auto& curve : curves_of_plane(m, {0, 0, -0.86 * half_mm.z()}, Vec3::UnitZ()).curve)
    mouths.push_back(t4_edges(m, curve, CutPolicy::must_divide, d));
  EXPECT_EQ(mouths.size(), 2u);
  for (const simplex::OperatorResult& o : mouths) EXPECT_TRUE(remove_component(m, m.ring(o.face[1])[0], d));
  EXPECT_TRUE(t3(m, mouths[0].face[0], mouths[1].face[0], d));
  compact(m);
  record_shape(m);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  EXPECT_EQ(census(m).components, 1);
  EXPECT_EQ(census(m).genus, 0);
  return m;
}

inline simplex::Mesh ellipsoid(int levels = 4, const Vec3& half_mm = {30, 20, 15}) {
  simplex::Mesh m = simplex::make_sphere({0, 0, 0}, 1, levels);
  for (Vec3& x : m.x_mm) x = x.cwiseProduct(half_mm);
  m.before_mm = m.x_mm;
  simplex::record_shape(m);
  return m;
}

/// A half ring (radius 40, thick 14 to 16 mm) with round ends: a sphere bent along y.
inline simplex::Mesh mandible(int levels = 4) {
  simplex::Mesh m = simplex::make_sphere({0, 0, 0}, 1, levels);
  for (Vec3& x : m.x_mm) {
    // Along the poles' axis: evenly by area, which leaves faces about as long as they are wide.
    const double s = x.y(), r = std::sqrt(std::max(0., 1 - s * s));
    const double angle = 1.3 * s, wide = 8 * std::pow(r, 0.6);
    const double c = r > 1e-9 ? x.x() / r : 0, d = r > 1e-9 ? x.z() / r : 0;
    const double radius = 40 + wide * c;
    x = Vec3(radius * std::sin(angle), radius * std::cos(angle), wide * d);
  }
  m.before_mm = m.x_mm;
  simplex::record_shape(m);
  if (simplex::extent(m).volume_mm3 < 0) {
    for (simplex::Row& r : m.nbr) std::swap(r[1], r[2]);
    m = simplex::make_mesh(m.nbr, m.x_mm);
  }
  return m;
}

/// Places taken outwards from the origin to the ellipsoid.
inline std::vector<Vec3> on_ellipsoid(std::vector<Vec3> p, const Vec3& half_mm = {70, 85, 65}) {
  for (Vec3& x : p) x /= x.cwiseQuotient(half_mm).norm();
  return p;
}

/// Places around a centre; with a wobble, no circle.
inline std::vector<Vec3> circle(const Vec3& centre, const Vec3& axis, double radius, int n, double wobble = 0) {
  const Vec3 a = axis.normalized(), u = a.unitOrthogonal(), v = a.cross(u);
  std::vector<Vec3> p;
  for (int i = 0; i < n; ++i) {
    const double t = 2 * std::numbers::pi * i / n, r = radius * (1 + wobble * std::sin(3 * t));
    p.push_back(centre + r * (std::cos(t) * u + std::sin(t) * v));
  }
  return p;
}

}  // namespace limberg::test
