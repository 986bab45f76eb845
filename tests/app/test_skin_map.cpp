// What the studies measure on the skin, against shapes that are known; and the law of the planar control.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "app/study/planar_law.h"
#include "app/study/seams.h"
#include "app/study/skin_map.h"
#include "sim/body/block.h"
#include "sim/commands/procedures/shapes.h"
#include "sim/fem/materials/catalogue.h"
#include "sim/geometry/vec.h"

namespace limberg::study {
namespace test_skin_map {

/// A flat skin of 40 mm, bent by `now`; triangles of which `keep` is false are left out.
template <class Now, class Keep>
Snapshot bent(Now now, Keep keep) {
  auto topology = std::make_shared<SurfaceTopology>();
  auto body = std::make_shared<Body>();
  topology->body = body;
  constexpr int n = 80;
  constexpr double h = 40.0 / n;
  std::vector<Vec3> X;
  std::vector<Tri> tri;
  std::vector<FaceKind> kind;
  Snapshot s;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) X.push_back({-20 + h * x, -20 + h * y, 0});
  for (const Vec3& p : X) s.x_mm.push_back(now(p).template cast<float>());
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      for (const Tri& t : {Tri{a, b, d}, Tri{a, d, c}})
        if (keep((X[size_t(t[0])] + X[size_t(t[1])] + X[size_t(t[2])]) / 3))
          tri.push_back(t), kind.push_back(FaceKind::skin);
    }
  const auto fill = [](auto& shared, const auto& list) { shared = std::remove_reference_t<decltype(shared)>(list); };
  fill(topology->view.X_mm, X), fill(topology->view.tri, tri), fill(topology->view.kind, kind);
  s.topology = topology;
  return s;
}

TEST(SkinMap, AnEvenStretchIsSeenEverywhere) {
  const auto s = bent([](const Vec3& p) { return Vec3(1.3 * p.x() + 0.0 * p.y(), 0.8 * p.y(), 0.6 * p.y()); },
                      [](const Vec3&) { return true; });
  const SkinMap map(s);
  const auto x = map.now_mm({3.21, -7.65});
  ASSERT_TRUE(x);
  EXPECT_LT((*x - Vec3(1.3 * 3.21, -0.8 * 7.65, -0.6 * 7.65)).norm(), 1e-5);
  EXPECT_FALSE(map.now_mm({21, 0}));
  const SkinMap::Stretch e = map.stretch({1, 2}, 3);
  EXPECT_NEAR(e.most, 1.3, 1e-4);
  EXPECT_NEAR(e.least, 1.0, 1e-4);
  EXPECT_NEAR(std::abs(e.direction.x()), 1, 1e-4);
  EXPECT_NEAR(map.percentile(0.99, 10, {}, 0), 1.3, 1e-4);
  EXPECT_NEAR(map.slack_share(10, 1), 0, 1e-9);  // 1.0 is more than 1/sqrt(1.3)
  EXPECT_NEAR(map.slack_share(10, 0.8), 1, 1e-9);
}

// A flap of 1.5 mm that has risen by 2 mm and grown thicker by 1, over
// a bed and beside the support: only its underside is the underside.
TEST(SkinMap, TheUndersideIsWhatLooksDownAndIsFree) {
  auto topology = std::make_shared<SurfaceTopology>();
  topology->body = std::make_shared<Body>();
  std::vector<Vec3> X;
  std::vector<Tri> tri;
  std::vector<FaceKind> kind;
  Snapshot s;
  const auto sheet = [&](double z, double now, bool up, FaceKind k) {
    const int a = int(X.size());
    for (const Vec2& p : {Vec2(-9, -9), Vec2(9, -9), Vec2(9, 9), Vec2(-9, 9)})
      X.push_back({p.x(), p.y(), z}), s.x_mm.push_back(Vec3f(float(p.x()), float(p.y()), float(now)));
    for (const Tri& t : {Tri{a, a + 1, a + 2}, Tri{a, a + 2, a + 3}})
      tri.push_back(up ? t : Tri{t[0], t[2], t[1]}), kind.push_back(k);
  };
  sheet(0, 3, true, FaceKind::skin);
  sheet(-1.5, 0.5, false, FaceKind::wall);
  sheet(-1.5, -1.6, true, FaceKind::wall);  // the bed
  sheet(-10, -10, false, FaceKind::fixed);  // what holds it
  const auto fill = [](auto& shared, const auto& list) { shared = std::remove_reference_t<decltype(shared)>(list); };
  fill(topology->view.X_mm, X), fill(topology->view.tri, tri), fill(topology->view.kind, kind);
  s.topology = topology;
  const SkinMap skin(s), under(s, SkinMap::Side::under);
  EXPECT_NEAR(skin.mean_height_mm({1, 2}, 10).value_or(-1), 3, 1e-6);
  EXPECT_NEAR(under.mean_height_mm({1, 2}, 10).value_or(-1), 2, 1e-6);
  EXPECT_FALSE(under.mean_height_mm({1, 2}, 0.1));  // no triangle's middle so near
}

// A wound with an apex of 300 degrees of tissue at the origin, opening along +x.
Figure notch() {
  Figure f;
  const double a = 30 / kDeg;
  f.wounds = {{{18 * std::cos(a), -18 * std::sin(a)}, {0, 0}, {18 * std::cos(a), 18 * std::sin(a)}}};
  if (std::abs(tissue_deg(f, {0, 1}) - 300) > 1) std::swap(f.wounds[0][0], f.wounds[0][2]);
  return f;
}

TEST(SkinMap, AConeShowsItsChargeAndAFlatSheetNone) {
  const Figure f = notch();
  ASSERT_NEAR(tissue_deg(f, {0, 1}), 300, 1e-9);
  const auto tissue = [](const Vec3& p) {
    return std::abs(std::atan2(p.y(), p.x())) > 30 / kDeg - 0.08 && p.norm() < 19;
  };
  // Polar angle from the middle of the tissue (the -x axis), 300 degrees of it to be closed to a full turn.
  const auto turn = [](const Vec3& p) { return std::atan2(-p.y(), -p.x()); };
  const auto cone = bent(
      [&](const Vec3& p) {
        const double r = p.head<2>().norm(), a = turn(p) * 360 / 300, s = 300.0 / 360;
        return Vec3(-r * s * std::cos(a), -r * s * std::sin(a), -r * std::sqrt(1 - s * s));
      },
      tissue);
  EXPECT_NEAR(SkinMap(cone).deficit_deg(f, {{0, 1}}, 6), 60, 2);
  EXPECT_LT(SkinMap(cone).turned_share(10), 0.01);
  const auto flat = bent(
      [&](const Vec3& p) {
        const double r = p.head<2>().norm(), a = turn(p) * 360 / 300;
        return Vec3(-r * std::cos(a), -r * std::sin(a), 0);
      },
      tissue);
  EXPECT_NEAR(SkinMap(flat).deficit_deg(f, {{0, 1}}, 6), 0, 2);
  EXPECT_NEAR(SkinMap(cone).curvature_deg(f, {{0, 1}}, 8, 3), 60, 1.5);
  EXPECT_NEAR(SkinMap(flat).curvature_deg(f, {{0, 1}}, 8, 3), 0, 0.1);
  // A tip that is rounded off over 5 mm bends as much in all; only rays from the tip do not show it.
  const auto blunt = bent(
      [&](const Vec3& p) {
        const double r = p.head<2>().norm(), a = turn(p) * 360 / 300, s = 300.0 / 360,
                     slope = std::sqrt(1 / (s * s) - 1), z = r * s;
        return Vec3(-r * s * std::cos(a), -r * s * std::sin(a), -slope * (std::hypot(z, 4) - 4));
      },
      tissue);
  const double at_14 = 14 * 300.0 / 360, steep = std::sqrt(1.44 - 1) * at_14 / std::hypot(at_14, 4);  // of its meridian
  EXPECT_NEAR(SkinMap(blunt).curvature_deg(f, {{0, 1}}, 14, 3), 360 * (1 - 1 / std::hypot(1, steep)), 2);
  EXPECT_LT(SkinMap(blunt).deficit_deg(f, {{0, 1}}, 14), 45);
}

// The same sector bent into a saddle z = (x^2 - y^2) / 40: its curvature against the integral of its closed form, K dA
// = -4 b^2 / (1 + 4 b^2 r^2)^1.5 dx dy with b = 1 / 40.
TEST(SkinMap, ASaddleCurvesTheOtherWay) {
  Figure f = notch();
  const auto saddle = bent([](const Vec3& p) { return Vec3(p.x(), p.y(), (p.x() * p.x() - p.y() * p.y()) / 40); },
                           [](const Vec3& p) { return p.norm() < 19; });
  f.wounds = {{{-10, 0}, {0, 0}, {10, 0}, {0, 0.001}}};  // two sectors of half a turn each, nearly
  const double b = 1.0 / 40, r = 10, closed = -2 * std::numbers::pi * (1 - 1 / std::sqrt(1 + 4 * b * b * r * r)) * kDeg;
  EXPECT_NEAR(SkinMap(saddle).curvature_deg(f, {{0, 1}, {0, 3}}, r, 2), closed, 1);
}

// A strip of 4 mm is taken out and its long sides are sewn together:
// level, as a roof, in a step, one side turned over onto the other.
TEST(SeamsLie, BesideEachOtherOrOneOnTheOther) {
  Figure f;
  f.wounds = {{{-10, 2}, {10, 2}, {10, -2}, {-10, -2}}};
  f.seams = {figures::seam(0, 1, 3, 2)};
  const auto lie = [&](auto upper, auto lower) {
    const auto s = bent([&](const Vec3& p) { return p.y() > 0 ? upper(p.x(), p.y() - 2) : lower(p.x(), -2 - p.y()); },
                        [](const Vec3& p) { return std::abs(p.y()) > 2; });
    return seams_lie(SkinMap(s), f, 4);
  };
  const auto level = [](double x, double in) { return Vec3(x, in, 0); };
  const SeamsLie flat = lie(level, [](double x, double in) { return Vec3(x, -in, 0); });
  EXPECT_EQ(flat.stitches, 4);
  EXPECT_NEAR(flat.least_opening_deg, 180, 1);
  EXPECT_NEAR(flat.most_step_mm, 0, 1e-3);
  const double c = std::sqrt(0.5);
  const SeamsLie roof = lie([&](double x, double in) { return Vec3(x, c * in, -c * in); },
                            [&](double x, double in) { return Vec3(x, -c * in, -c * in); });
  EXPECT_NEAR(roof.least_opening_deg, 90, 3);
  EXPECT_NEAR(roof.most_step_mm, 0, 1e-3);
  const SeamsLie step = lie(level, [](double x, double in) { return Vec3(x, -in, 1.2); });
  EXPECT_NEAR(step.most_step_mm, 1.2, 1e-3);
  const SeamsLie turned_over = lie(level, [](double x, double in) { return Vec3(x, in, 0.1); });
  EXPECT_LT(turned_over.least_opening_deg, 5);
}

TEST(PlaneMembrane, ForcesAndTangentAreDerivativesOfTheEnergy) {
  const LawPtr law = plane_membrane(20, 200, 0.9);
  for (const double squeeze : {1.0, 0.4, 0.05, -0.3}) {  // down to inverted
    Mat3 F;
    F << 1.2, 0.3, 0.1, -0.2, 0.9 * squeeze, -0.05, 0.07, 0.02, 0.8;
    const auto r = law->at(F);
    const Mat9 C = law->tangent_kPa(F, false);
    constexpr double h = 1e-5;
    for (int k = 0; k < 9; ++k) {
      Mat3 a = F, b = F;
      a.data()[k] -= h, b.data()[k] += h;
      const auto ra = law->at(a), rb = law->at(b);
      EXPECT_NEAR((rb.energy_kPa - ra.energy_kPa) / (2 * h), r.P_kPa.data()[k],
                  1e-4 * (1 + std::abs(r.P_kPa.data()[k])));
      for (int l = 0; l < 9; ++l)
        EXPECT_NEAR((rb.P_kPa.data()[l] - ra.P_kPa.data()[l]) / (2 * h), C(l, k), 1e-3 * (1 + std::abs(C(l, k))));
    }
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Mat9>(law->tangent_kPa(F, true)).eigenvalues().minCoeff(), -1e-9);
  }
}

TEST(PlaneMembrane, IsThatOfConstantVolumeUnderPlaneStressAndRestsWhenStretched) {
  // Uniaxial: the free width is l^-1/2 and the stress mu (l^2 - 1/l).
  const LawPtr law = plane_membrane(1, 10, 1);
  for (const double l : {1.2, 1.5, 2.0}) {
    Mat3 F = Mat3::Identity();
    F(0, 0) = l, F(1, 1) = 1 / std::sqrt(l);
    const Mat3 P = law->at(F).P_kPa;
    EXPECT_NEAR(P(0, 0) * l, l * l - 1 / l, 1e-12);
    EXPECT_NEAR(P(1, 1), 0, 1e-12);
    EXPECT_NEAR(P(2, 2), 0, 1e-12);
  }
  const Material m = membrane_material(20, 1.1);
  const auto laws = laws_with_membrane();
  const LayerResponse r = layer_response(m, laws.get());
  EXPECT_NEAR(r.lambda_kPa, 0.02, 1e-9);
  const Mat3 M = Vec3(1.1, 1.1, 1 / 1.21).asDiagonal();
  EXPECT_NEAR(rest_pressure_kPa(r, M, Vec3::UnitZ()), 0, 1e-9);
}

}  // namespace test_skin_map
}  // namespace limberg::study
