// Points, lengths and angles against surfaces whose form is known.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "sim/body/obj.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/measure/elongations.h"
#include "sim/measure/perfusion.h"
#include "sim/measure/predicted.h"
#include "sim/measure/skin_strain.h"
#include "tests/sim/measure/views.h"

namespace limberg {
namespace test_foretold {

constexpr double kRad = std::numbers::pi / 180;

TEST(SkinPoints, FollowTheSkin) {
  const auto body = measured_block({60, 60, 10}, 1.3);
  const Skin skin(body);
  const SurfaceView v = view_of(*body);
  const auto x = deformed(v, [](const Vec3& X) { return Vec3(1.1 * X.x() + 2, X.y() - 0.2 * X.x(), X.z() + 3); });
  const SkinPoints points(v, skin);
  for (const ChartPoint& p : {ChartPoint(0.37, -4.2), ChartPoint(-21, 13.3), ChartPoint(29.9, 29.9)}) {
    const auto m = landmark(points, x, skin, p);
    ASSERT_TRUE(m);
    const Vec3 d(0.1 * p.x() + 2, -0.2 * p.x(), 3);
    EXPECT_NEAR(m->displacement_mm, d.norm(), 1e-4);
    EXPECT_NEAR(m->along_mm, d.x(), 1e-4);  // tension lines along x
    EXPECT_NEAR(m->across_mm, d.y(), 1e-4);
    EXPECT_NEAR(m->up_mm, d.z(), 1e-4);
  }
  EXPECT_FALSE(landmark(points, x, skin, {31, 0}));
}

TEST(Predicted, AConeHasItsDeficitHeightAndPlace) {
  const auto body = measured_block({80, 60, 10}, 0.6);
  const Skin skin(body);
  const SurfaceView v = view_of(*body);
  const PlanOnSkin plan = plan_on(skin, {"fusiform", {}, {0, 0}, 0, false});
  const auto all = charges(plan.figure);
  // The spindle's right tip becomes the apex of a cone: circles around it keep their length, distances grow by 1 / cos.
  const Vec2 tip(0.5 * 14 * 3.5, 0);
  const double slope = 0.4, beta = std::atan(slope);
  const auto x = deformed(v, [&](const Vec3& X) {
    return Vec3(X.x(), X.y(), X.z() - (X.z() == 0 ? slope * (X.head<2>() - tip).norm() : 0) + (X.z() == 0 ? 4 : 0));
  });
  const SkinPoints points(v, skin);
  bool found = false;
  for (const PredictedPoint& p : predicted_points(v, x, skin, points, plan)) {
    if ((p.at - tip).norm() > 0.1) continue;
    found = true;
    EXPECT_NEAR(p.q_deg, 4 * std::atan(1 / 3.5) / kRad,
                6);  // arcs are drawn as polygons, whose first chord cuts the angle
    ASSERT_TRUE(p.deficit_deg);
    EXPECT_NEAR(*p.deficit_deg, 360 - (360 - p.q_deg) * std::cos(beta), 1.5);
    EXPECT_NEAR(p.height_mm, 4, slope * 0.6);
  }
  EXPECT_TRUE(found);
  EXPECT_GE(all.size(), 2u);
}

TEST(Predicted, ChargesHaveASectorForEachPlace) {
  for (const Procedure& p : procedures())
    for (const Charge& c : charges(p.figure(p.defaults()))) {
      ASSERT_EQ(c.sector.size(), c.meeting.size()) << p.name;
      double sum = 0;
      for (const TissueSector& s : c.sector) sum += s.sweep_deg;
      EXPECT_NEAR(c.q_deg, 360 - sum, 1e-9) << p.name;
    }
}

TEST(Elongations, ATentIsLongerThanItsShadow) {
  const auto body = measured_block({60, 60, 10}, 1);
  const Skin skin(body);
  const SurfaceView v = view_of(*body);
  const CentralLimb limb{{-17, 0}, {0, 10}, {0, -10}, {17, 0}};
  const double h = 6;
  const auto x = deformed(v, [&](const Vec3& X) {
    return Vec3(X.x(), 1.2 * X.y(), X.z() + (X.z() == 0 ? h * std::max(0.0, 1 - std::abs(X.y()) / 10) : 0));
  });
  const auto e = elongations(v, x, skin, limb);
  ASSERT_TRUE(e);
  EXPECT_NEAR(e->direct, 1.2, 1e-5);
  EXPECT_NEAR(e->planimetric, 1.2, 1e-5);
  EXPECT_NEAR(e->stereometric, 2 * std::hypot(12.0, h) / 20, 1e-4);
}

TEST(Perfusion, FallsWithTheWayToSkinThatIsAttached) {
  const auto body = measured_block({120, 80, 10}, 1);
  const Skin skin(body);
  for (const double half : {5.0, 12.0, 28.0}) {
    SurfaceView v = view_of(*body);
    const int32_t n = int32_t(v.X_mm.size());  // a floor 4 mm deep under a strip along y
    for (const Vec3& p : {Vec3(-half, -40, -4), Vec3(half, -40, -4), Vec3(half, 40, -4), Vec3(-half, 40, -4)})
      v.X_mm.push_back(p);
    for (const Tri& t : {Tri{n, n + 1, n + 2}, Tri{n, n + 2, n + 3}})
      v.tri.push_back(t), v.kind.push_back(FaceKind::wall);
    const Perfusion p = perfusion(v, skin);
    EXPECT_NEAR(p.undermined_mm2, 2 * half * 80, 0.03 * 2 * half * 80 + 80) << half;
    EXPECT_GT(p.farthest_mm, half - 1.5) << half;
    EXPECT_LT(p.farthest_mm, 1.1 * half + 1) << half;
    EXPECT_NEAR(p.least, std::clamp((30 - p.farthest_mm) / 25, 0.0, 1.0), 1e-6) << half;
    EXPECT_EQ(p.severed_mm2, 0) << half;
    if (half < 20)
      EXPECT_EQ(p.below_40_mm2, 0) << half;
    else
      EXPECT_NEAR(p.below_40_mm2, 2 * (28 - 20) * 80, 0.25 * 2 * 8 * 80) << half;
  }
  EXPECT_EQ(perfusion(view_of(*body), skin).least, 1);
}

TEST(Perfusion, TheFarSideOfAClosedBodyIsNotUndermined) {
  constexpr double R = 40;
  constexpr int n = 48, m = 24;  // around, from pole to pole
  std::string obj = "v 0 0 40\nv 0 0 -40\n";
  for (int j = 1; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      const double a = std::numbers::pi * j / m, b = 2 * std::numbers::pi * i / n;
      obj += "v " + std::to_string(R * std::sin(a) * std::cos(b)) + " " +
             std::to_string(R * std::sin(a) * std::sin(b)) + " " + std::to_string(R * std::cos(a)) + "\n";
    }
  const auto at = [&](int j, int i) { return std::to_string(3 + (j - 1) * n + i % n); };
  for (int i = 0; i < n; ++i) {
    obj += "f 1 " + at(1, i) + " " + at(1, i + 1) + "\n";
    for (int j = 1; j + 1 < m; ++j)
      obj += "f " + at(j, i) + " " + at(j + 1, i) + " " + at(j + 1, i + 1) + "\nf " + at(j, i) + " " +
             at(j + 1, i + 1) + " " + at(j, i + 1) + "\n";
    obj += "f 2 " + at(m - 1, i + 1) + " " + at(m - 1, i) + "\n";
  }
  ObjSpec spec;
  spec.path = "ball";
  spec.layers.resize(1);
  spec.deep_direction = {1, 0, 0}, spec.deep_angle_deg = 20;
  const auto body = std::make_shared<Body>(parse_obj(obj, spec));
  const Skin skin(body);
  for (const double side : {1., -1.}) {  // what faces the chart, and what turns away from it
    SurfaceView v = view_of(*body);
    const auto first = int32_t(v.X_mm.size());
    for (const Vec3& p :
         {Vec3(-8, -8, 35 * side), Vec3(8, -8, 35 * side), Vec3(8, 8, 35 * side), Vec3(-8, 8, 35 * side)})
      v.X_mm.push_back(p);
    for (const Tri& t : {Tri{first, first + 1, first + 2}, Tri{first, first + 2, first + 3}})
      v.tri.push_back(t), v.kind.push_back(FaceKind::wall);
    const Perfusion p = perfusion(v, skin);
    // Outwards along the ball's normals: R² times the solid angle of a square of half a side a at a distance d,
    // 4 asin(a²/(a² + d²)): 317.9 mm²; triangles of 5 mm, counted whole, at its edge.
    const double above = R * R * 4 * std::asin(8. * 8 / (8. * 8 + 35. * 35));
    EXPECT_NEAR(p.undermined_mm2, above, 60) << side;
    EXPECT_EQ(p.severed_mm2, 0) << side;
  }
}

// An ear stands over the cheek, both facing the chart: a pocket in one leaves the other attached.
TEST(Perfusion, WhatLiesBehindAnotherFoldIsNotUndermined) {
  // A C of three plates of 10 mm: front, back, and what joins them at y = 0. Skin is all that does not face -z.
  const double y[] = {0, 10, 60}, z[] = {0, 10, 20, 30};
  std::string obj;
  for (const double x : {-30., 30.})
    for (const double h : y)
      for (const double k : z)
        obj += "v " + std::to_string(x) + " " + std::to_string(h) + " " + std::to_string(k) + "\n";
  const auto at = [](int side, int j, int k) { return std::to_string(1 + side * 12 + j * 4 + k) + " "; };
  const auto cell = [](int j, int k) { return j >= 0 && j < 2 && k >= 0 && k < 3 && (j == 0 || k != 1); };
  for (int j = 0; j < 2; ++j)
    for (int k = 0; k < 3; ++k) {
      if (!cell(j, k)) continue;
      obj += "f " + at(0, j, k) + at(0, j, k + 1) + at(0, j + 1, k + 1) + at(0, j + 1, k) + "\n";
      obj += "f " + at(1, j, k) + at(1, j + 1, k) + at(1, j + 1, k + 1) + at(1, j, k + 1) + "\n";
      const auto wall = [&](int j0, int k0, int j1, int k1) {
        obj += "f " + at(0, j0, k0) + at(0, j1, k1) + at(1, j1, k1) + at(1, j0, k0) + "\n";
      };
      if (!cell(j - 1, k)) wall(j, k + 1, j, k);
      if (!cell(j + 1, k)) wall(j + 1, k, j + 1, k + 1);
      if (!cell(j, k - 1)) wall(j, k, j + 1, k);
      if (!cell(j, k + 1)) wall(j + 1, k + 1, j, k + 1);
    }
  ObjSpec spec;
  spec.path = "fold";
  spec.layers.resize(1);
  const auto body = std::make_shared<Body>(parse_obj(obj, spec));
  const Skin skin(body);
  for (const double depth_from : {30., 10.}) {  // below the front of either plate
    SurfaceView v = view_of(*body);
    const auto first = int32_t(v.X_mm.size());
    for (const Vec3& p : {Vec3(-30, 10, depth_from - 3), Vec3(30, 10, depth_from - 3), Vec3(30, 60, depth_from - 3),
                          Vec3(-30, 60, depth_from - 3)})
      v.X_mm.push_back(p);
    for (const Tri& t : {Tri{first, first + 1, first + 2}, Tri{first, first + 2, first + 3}})
      v.tri.push_back(t), v.kind.push_back(FaceKind::wall);
    EXPECT_NEAR(perfusion(v, skin).undermined_mm2, 60 * 50, 1) << depth_from;
  }
}

TEST(MembraneState, AngleBetweenTensionAndFibres) {
  Material m;
  m.young_kPa = 50, m.poisson = 0.45;
  const double turn = 35 * kRad, most = 1.4, least = 0.95;
  Eigen::Matrix2d R, F;
  R << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
  F = R * Eigen::Vector2d(most, least).asDiagonal() * R.transpose();
  const std::array<Vec3, 3> X{Vec3(0, 0, 0), Vec3(1, 0.2, 0), Vec3(0.1, 1, 0)};
  std::array<Vec3, 3> x;
  for (size_t k = 0; k < 3; ++k) {
    const Vec2 p = F * X[k].head<2>();
    x[k] = Vec3(p.y(), 2, p.x());  // and turned in space
  }
  const Vec2 fibre = F.col(0);
  const double want = std::abs(turn - std::atan2(fibre.y(), fibre.x())) / kRad;
  EXPECT_NEAR(membrane_state(X, x, m, Vec3::UnitX()).angle_deg, want, 1e-9);
  EXPECT_NEAR(membrane_state(X, x, m, Vec3::UnitY()).angle_deg, std::abs(turn - std::atan2(F(1, 1), F(0, 1))) / kRad,
              1e-9);
  EXPECT_EQ(membrane_state(X, X, m, Vec3::UnitX()).angle_deg, -1);  // nothing pulls
}

}  // namespace test_foretold
}  // namespace limberg
