// The mean of surfaces whose mean is known, however they lie and are meshed, and of walls thinner than they lie apart.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "sim/imaging/register/average_surface.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"

namespace limberg {
namespace test_average_surface {

constexpr double kDegree = 3.14159265358979 / 180;

/// An uneven ellipsoid with a boss and a hollow; `boss` says how high.
Vec3 place(const Vec3& u, double boss, double deeper_mm = 0) {
  const double r = 1 + boss * std::exp(-8 * (u - Vec3(0, -1, -0.2).normalized()).squaredNorm()) +
                   0.1 * std::exp(-10 * (u - Vec3(0.8, 0.3, 0.5).normalized()).squaredNorm()) -
                   0.08 * std::exp(-12 * (u - Vec3(-0.4, -0.8, 0.4).normalized()).squaredNorm());
  const Vec3 x = (r * u).cwiseProduct(Vec3(70, 95, 80));
  return x * (1 - deeper_mm / x.norm());
}

/// Its triangles begin at a pole of their own.
Surface boss(double high, int levels, double turned_deg, double deeper_mm = 0) {
  const simplex::DualTriangles d = simplex::dual_triangles(simplex::make_sphere({0, 0, 0}, 1, levels));
  const Mat3 turn = Eigen::AngleAxisd(turned_deg * kDegree, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  Surface s{d.X_mm, d.tri};
  for (Vec3& x : s.x_mm) x = place(turn * x.normalized(), high, deeper_mm);
  return s;
}

/// The same as a shell, `wall_mm` thick.
Surface shell(double high, int levels, double turned_deg, double wall_mm) {
  Surface s = boss(high, levels, turned_deg), inner = boss(high, levels, turned_deg, wall_mm);
  for (Tri& t : inner.tri) std::swap(t[1], t[2]);
  append(s, inner);
  return s;
}

Similarity elsewhere(double deg, const Vec3& by, double scale = 1) {
  Similarity m;
  m.R = Eigen::AngleAxisd(deg * kDegree, Vec3(-1, 0.4, 0.7).normalized()).toRotationMatrix();
  m.t_mm = by, m.scale = scale;
  return m;
}
Surface moved(Surface s, const Similarity& by) {
  for (Vec3& x : s.x_mm) x = by(x);
  return s;
}

/// rms, after it was laid upon the other.
double off(const Surface& a, const Surface& b, bool with_scale = false) {
  InlineWorkers w;
  const SurfaceTarget target(b);
  IcpSettings s;
  s.keep = 1, s.with_scale = with_scale;
  const IcpResult r = icp(a, target, {}, s, w);
  EXPECT_TRUE(r) << r.reason;
  return distance_map(a, r.map, target, w).rms_mm;
}

TEST(AverageSurface, IsTheMeanOfAFamilyWhicheverComesFirst) {
  InlineWorkers w;
  const Surface truth = boss(0.12, 5, 0);
  const Surface family[] = {boss(0.04, 4, 0), moved(boss(0.12, 4, 25), elsewhere(20, {30, -10, 5})),
                            moved(boss(0.2, 4, 70), elsewhere(-35, {-80, 20, 60}))};
  EXPECT_GT(off(family[0], truth), 0.5);  // its boss is some 7 mm too low
  for (size_t first = 0; first < 3; ++first) {
    const AverageSurface a = average_surface({family[first], family[(first + 1) % 3], family[(first + 2) % 3]}, {}, w);
    ASSERT_TRUE(a) << a.reason;
    EXPECT_TRUE(a.still);
    EXPECT_EQ(a.mean.tri.size(), family[first].tri.size());
    IcpResult back = icp_from_anywhere(a.mean, SurfaceTarget(truth), truth, {}, w);
    const double rms = off(moved(a.mean, back.map), truth);
    std::printf("%d rounds, %.3f mm rms from the mean of the family\n", a.rounds, rms);
    // Flat triangles of edges of 9 mm lie .1 mm within a ball of 80 mm: h^2 / 8 R.
    EXPECT_LT(rms, 0.15);
    EXPECT_GT(a.half, 0.99);
    // They spread most at the boss: by 95 mm times .08 times sqrt(2 / 3), less what laying them upon each other takes.
    size_t most = 0;
    for (size_t v = 0; v < a.spread_mm.size(); ++v)
      if (a.spread_mm[v] > a.spread_mm[most]) most = v;
    const Vec3 there = back.map(a.mean.x_mm[most]).normalized();
    EXPECT_LT(std::acos(there.dot(Vec3(0, -1, -0.2).normalized())) / kDegree, 20);
    EXPECT_LT(a.spread_mm[most], 95 * 0.08 * std::sqrt(2. / 3));
    EXPECT_GT(a.spread_mm[most], 0.6 * 95 * 0.08 * std::sqrt(2. / 3));
  }
}

TEST(AverageSurface, WallsThinnerThanTheyLieApartStayWalls) {
  InlineWorkers w;
  constexpr double kWall_mm = 1.5;
  const AverageSurface a =
      average_surface({shell(0.04, 4, 0, kWall_mm), shell(0.12, 4, 25, kWall_mm), shell(0.2, 4, 70, kWall_mm)}, {}, w);
  ASSERT_TRUE(a) << a.reason;
  EXPECT_LT(off(a.mean, shell(0.12, 5, 0, kWall_mm)), 0.3);
  // Its outer sheet, then its inner one, each with half of the vertices.
  const auto half = int32_t(a.mean.x_mm.size() / 2);
  Surface sheet[2];
  for (const int side : {0, 1}) {
    sheet[side].x_mm.assign(a.mean.x_mm.begin() + side * half, a.mean.x_mm.begin() + (side + 1) * half);
    for (const Tri& t : a.mean.tri)
      if ((t[0] >= half) == (side == 1))
        sheet[side].tri.push_back({t[0] - side * half, t[1] - side * half, t[2] - side * half});
  }
  for (Tri& t : sheet[1].tri) std::swap(t[1], t[2]);
  const std::vector<double> wall = distance_map(sheet[0], {}, SurfaceTarget(sheet[1]), w).signed_mm;
  double sum = 0, least = 1e9;
  for (const double x : wall) sum += x, least = std::min(least, x);
  std::printf("walls %.2f mm thick, %.2f at least\n", sum / double(wall.size()), least);
  EXPECT_NEAR(sum / double(wall.size()), kWall_mm, 0.2);
  EXPECT_GT(least, 0.3);
}

TEST(AverageSurface, SizesAreEvenedOutWhereThatIsAskedFor) {
  InlineWorkers w;
  const std::vector<Surface> three{moved(boss(0.12, 4, 0), elsewhere(0, {0, 0, 0}, 0.9)), boss(0.12, 4, 25),
                                   moved(boss(0.12, 4, 70), elsewhere(15, {10, 0, 0}, 1 / 0.9))};
  AverageSettings s;
  s.with_scale = true;
  const AverageSurface a = average_surface(three, s, w);
  ASSERT_TRUE(a) << a.reason;
  double size = 0;
  for (const Vec3& x : a.mean.x_mm) size += (x - middle_of(a.mean.x_mm)).norm();
  double truth = 0;
  for (const Vec3& x : three[1].x_mm) truth += (x - middle_of(three[1].x_mm)).norm();
  EXPECT_NEAR(size / truth, 1, 0.005);
  EXPECT_NEAR(a.of[0].map.scale, 1 / 0.9, 0.01);
  EXPECT_NEAR(a.of[2].map.scale, 0.9, 0.01);
  for (const AverageSurface::One& o : a.of) EXPECT_LT(o.rms_mm, 0.25);
}

TEST(AverageSurface, WhatHasNoMeanSaysWhy) {
  InlineWorkers w;
  const Surface one = boss(0.1, 2, 0);
  EXPECT_NE(average_surface({one}, {}, w).reason.find("two or more"), std::string::npos);
  EXPECT_NE(average_surface({one, {one.x_mm, {}}}, {}, w).reason.find("surface 2 has no triangles"), std::string::npos);
  AverageSettings none;
  none.keep = 0;
  EXPECT_THROW(average_surface({one, one}, none, w), InputError);
  const simplex::FanTriangles f = simplex::fan_triangles(simplex::make_plane(60, 60, 4));
  EXPECT_NE(average_surface({{f.X_mm, f.tri}, {f.X_mm, f.tri}}, {}, w).reason.find("slip"), std::string::npos);
}

}  // namespace test_average_surface
}  // namespace limberg
