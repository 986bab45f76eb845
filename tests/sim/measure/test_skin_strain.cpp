// Membrane stretch and stress against the energy they come from, by finite differences and in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/fem/materials/catalogue.h"
#include "sim/measure/skin_strain.h"
#include "tests/sim/measure/views.h"

namespace limberg {
namespace test_skin_strain {

Material skin_material(double along = 1, double across = 1) {
  Material m;
  m.young_kPa = 60;
  m.poisson = 0.45;
  m.prestretch_along = along;
  m.prestretch_across = across;
  return m;
}

const std::array<Vec3, 3> kRest{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.2, 0.9, 0)};

std::array<Vec3, 3> mapped(const Mat3& F) { return {F * kRest[0], F * kRest[1], F * kRest[2]}; }

// The energy density of fem_model.h with principal stretches a,
// b in the plane and the thickness stretch that makes it least.
double membrane_energy(const Material& m, double a, double b) {
  const double p = m.prestretch_along, q = m.prestretch_across, n = 1 / (p * q);
  const double mu = m.mu_kPa(), lambda = m.lambda_kPa() + mu, p0 = mu * n * n;
  const auto W = [&](double s) {
    const double J = a * b * s;
    return 0.5 * mu * (a * a * p * p + b * b * q * q + s * s * n * n) + 0.5 * lambda * (J - 1) * (J - 1) - p0 * (J - 1);
  };
  double lo = 0.05, hi = 5;  // golden section; W is convex in s
  const double g = 0.5 * (std::sqrt(5.0) - 1);
  for (int i = 0; i < 200; ++i) {
    const double u = hi - g * (hi - lo), v = lo + g * (hi - lo);
    (W(u) < W(v) ? hi : lo) = W(u) < W(v) ? v : u;
  }
  return W(0.5 * (lo + hi));
}

TEST(Membrane, StressIsTheDerivativeOfTheEnergy) {
  // For stretches along the prestretch axes: sigma_1 = (a / J) dW/da at the relaxed thickness.
  for (const auto& [p, q] : {std::pair(1.0, 1.0), {1.1, 1.06}, {1.2, 0.95}})
    for (const auto& [a, b] : {std::pair(1.0, 1.0), {1.3, 1.0}, {1.2, 1.2}, {1.5, 0.8}}) {
      const Material m = skin_material(p, q);
      const MembraneState s = membrane_state(kRest, mapped(Vec3(a, b, 1).asDiagonal()), m, Vec3::UnitX());
      const double mu = m.mu_kPa(), lambda = m.lambda_kPa() + mu, n2 = 1 / (p * p * q * q);
      const double thick = (mu * n2 + lambda) / (mu * n2 / (a * b) + lambda * a * b), J = a * b * thick;
      const double h = 1e-5;
      const double da = (membrane_energy(m, a + h, b) - membrane_energy(m, a - h, b)) / (2 * h);
      const double db = (membrane_energy(m, a, b + h) - membrane_energy(m, a, b - h)) / (2 * h);
      const double want = std::max(a / J * da, b / J * db);
      EXPECT_NEAR(s.stress_kPa, want,
                  1e-5 * (1 + std::abs(want)));  // central difference of step 1e-5 on an energy of 1e2
      EXPECT_NEAR(s.stretch, std::max(a * p, b * q), 1e-12);
    }
}

// The same for any deformation, shear included: Cauchy stress from the derivative of the energy by all of F.
TEST(Membrane, StressInShearIsTheDerivativeOfTheEnergy) {
  using Mat2 = Eigen::Matrix2d;
  const Material m = skin_material(1.2, 1.05);
  const Mat2 A0 = Vec2(1.2, 1.05).asDiagonal();
  const auto energy = [&](const Mat2& F) {
    const double mu = m.mu_kPa(), lambda = m.lambda_kPa() + mu, n2 = 1 / (1.2 * 1.2 * 1.05 * 1.05),
                 det = F.determinant();
    double best = 1e300;
    for (double lo = 0.2, hi = 3, k = 0; k < 100; ++k) {
      const double g = 0.5 * (std::sqrt(5.0) - 1), u = hi - g * (hi - lo), v = lo + g * (hi - lo);
      const auto W = [&](double s) {
        const double J = det * s;
        return 0.5 * mu * ((F * A0).squaredNorm() + s * s * n2) + 0.5 * lambda * (J - 1) * (J - 1) - mu * n2 * (J - 1);
      };
      best = std::min({best, W(u), W(v)});
      (W(u) < W(v) ? hi : lo) = W(u) < W(v) ? v : u;
    }
    return best;
  };
  Mat2 F;
  F << 1.15, 0.3, -0.1, 0.95;
  Mat2 P;
  const double h = 1e-5;
  for (int i = 0; i < 4; ++i) {
    Mat2 plus = F, minus = F;
    plus(i) += h;
    minus(i) -= h;
    P(i) = (energy(plus) - energy(minus)) / (2 * h);
  }
  const double mu = m.mu_kPa(), lambda = m.lambda_kPa() + mu, n2 = 1 / (1.2 * 1.2 * 1.05 * 1.05), det = F.determinant();
  const double J = det * (mu * n2 + lambda) / (mu * n2 / det + lambda * det);
  const Mat2 sigma = P * F.transpose() / J;
  EXPECT_NEAR(sigma(0, 1), sigma(1, 0), 1e-5 * sigma.norm());
  const double mean = 0.5 * sigma.trace(), want = mean + std::hypot(0.5 * (sigma(0, 0) - sigma(1, 1)), sigma(0, 1));
  Mat3 F3 = Mat3::Identity();
  F3.topLeftCorner<2, 2>() = F;
  EXPECT_NEAR(membrane_state(kRest, mapped(F3), m, Vec3::UnitX()).stress_kPa, want, 1e-5 * want);
}

// The way by bisection gives what the closed one gives; and a free membrane of fibrous skin has no stress across.
TEST(Membrane, ALayerWithALawOfItsOwn) {
  Material m = skin_material(1.1, 1.06), rivlin = m;
  rivlin.law = {"mooney-rivlin", {{"c10_kPa", {m.mu_kPa() / 2}}, {"c01_kPa", {0}}}};
  const LayerResponse law = layer_response(rivlin);
  Mat3 F;
  F << 1.2, 0.3, 0, -0.1, 0.9, 0, 0, 0, 1;
  const MembraneState a = membrane_state(kRest, mapped(F), m, {1, 0.3, 0}),
                      b = membrane_state(kRest, mapped(F), rivlin, {1, 0.3, 0}, law);
  EXPECT_NEAR(a.stress_kPa, b.stress_kPa, 1e-6 * a.stress_kPa);
  EXPECT_NEAR(a.von_mises_kPa, b.von_mises_kPa, 1e-6 * a.von_mises_kPa);
  EXPECT_EQ(a.stretch, b.stretch);
  // One family along x, stretched along it: the closed form of homogeneous_states.h.
  Material skin = skin_material();
  skin.poisson = 0.4999;
  skin.law = {"gasser-ogden-holzapfel",
              {{"mu_kPa", {10}}, {"k1_kPa", {100}}, {"k2", {1}}, {"kappa", {0.1}}, {"fibre_angle_deg", {0}}}};
  const double l = 1.2, t = 1 / std::sqrt(l);
  const MembraneState s =
      membrane_state(kRest, mapped(Vec3(l, t, 1).asDiagonal()), skin, Vec3::UnitX(), layer_response(skin));
  EXPECT_NEAR(s.stress_kPa, 81.456, 0.005 * 81.456);
}

TEST(Membrane, SmallUniaxialStrainGivesYoungsModulus) {
  // The reparametrised constants reproduce mu and lambda, hence E and nu, to first order.
  const Material m = skin_material();
  const double e = 1e-6;
  // Plane stress: lateral strain -nu e makes the second stress vanish.
  const auto s = membrane_state(kRest, mapped(Vec3(1 + e, 1 - m.poisson * e, 1).asDiagonal()), m, Vec3::UnitX());
  EXPECT_NEAR(s.stress_kPa / e, 60, 1e-3);  // next order is E e
  EXPECT_NEAR(s.von_mises_kPa / e, 60, 1e-3);
}

TEST(Membrane, RestWithoutPrestretchIsFreeAndMotionChangesNothing) {
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> u(-1, 1);
  EXPECT_NEAR(membrane_state(kRest, kRest, skin_material(), Vec3::UnitX()).stress_kPa, 0, 1e-10);
  const Material m = skin_material(1.1, 1.05);
  for (int n = 0; n < 50; ++n) {
    Mat3 F;
    for (int i = 0; i < 9; ++i) F(i) = 0.3 * u(rng);
    F += Mat3::Identity();
    const Mat3 R = Eigen::AngleAxisd(3 * u(rng), Vec3(u(rng), u(rng), u(rng)).normalized()).toRotationMatrix();
    const Vec3 along(u(rng), u(rng), 0);
    const auto a = membrane_state(kRest, mapped(F), m, along);
    auto moved = mapped(R * F);
    for (Vec3& p : moved) p += Vec3(3, 4, 5);
    const auto b = membrane_state(kRest, moved, m, along);
    EXPECT_NEAR(a.stress_kPa, b.stress_kPa, 1e-9 * 60);
    EXPECT_NEAR(a.stretch, b.stretch, 1e-12);
    // Turning rest, prestretch and present together changes nothing either.
    std::array<Vec3, 3> X{R * kRest[0], R * kRest[1], R * kRest[2]};
    const auto c = membrane_state(X, mapped(F), m, R * along);
    EXPECT_NEAR(a.stress_kPa, c.stress_kPa, 1e-9 * 60);
  }
}

TEST(SkinStrain, HomogeneousStretchOfABlock) {
  const Material m = skin_material(1.1, 1.05);
  const auto body = measured_block({20, 16, 5}, 2, m);
  const SurfaceView v = view_of(*body);
  const auto x = deformed(v, [](const Vec3& X) { return Vec3(1.2 * X.x(), X.y(), X.z()); });
  const SkinStrain s = skin_strain(v, x, *body);
  const auto one = membrane_state(kRest, mapped(Vec3(1.2, 1, 1).asDiagonal()), m, Vec3::UnitX());
  EXPECT_NEAR(s.stretch_max, 1.32, 1e-6);
  EXPECT_NEAR(s.stretch_p99, 1.32, 1e-6);
  EXPECT_NEAR(s.stress_max_kPa, one.stress_kPa, 1e-4);  // float positions: 1e-6 of 10 mm over 1 mm
  EXPECT_NEAR(s.stress_p95_kPa, one.stress_kPa, 1e-4);
  EXPECT_NEAR(s.area_mm2, 320, 1e-9);
}

// One vertex drawn out by a bad cut: a fibre law grows as exp(k2 E^2), and one small triangle gave 2.93e11 kPa in an
// operation.
TEST(SkinStrain, ATriangleBeyondTheLawMakesNoFigureOfTheSkin) {
  Material m = skin_material();
  m.law = {"gasser-ogden-holzapfel",
           {{"mu_kPa", {18}}, {"k1_kPa", {100}}, {"k2", {2}}, {"kappa", {0.2}}, {"fibre_angle_deg", {41}}}};
  const auto body = measured_block({40, 40, 5}, 1, m);
  const SurfaceView v = view_of(*body);
  auto x = deformed(v, [](const Vec3& X) { return Vec3(1.1 * X.x(), X.y(), X.z()); });
  const SkinStrain plain = skin_strain(v, x, *body);
  EXPECT_EQ(plain.beyond_law_mm2, 0);
  for (size_t i = 0; i < x.size(); ++i)
    if (v.X_mm[i] == Vec3(0, 0, 0)) x[i] += Vec3f(1.6f, 1.6f, 0);  // the triangles round it are drawn out threefold
  const std::vector<MembraneState> states = skin_states(v, x, *body);
  double worst = 0;
  for (const MembraneState& s : states) worst = std::max(worst, s.stress_kPa);
  EXPECT_GT(worst, 1e5) << "the law is beyond its range there";
  const SkinStrain s = skin_strain(v, x, *body);
  EXPECT_GT(s.beyond_law_mm2, 0.4);
  EXPECT_LE(s.beyond_law_mm2, 4);  // the triangles round one vertex
  EXPECT_LT(s.stress_max_kPa, 3e3);
  EXPECT_NEAR(s.stress_p95_kPa, plain.stress_p95_kPa, 1e-3 * plain.stress_p95_kPa);
  EXPECT_NEAR(s.stretch_p99, plain.stretch_p99, 1e-5);
  // All of it beyond: no law tells a stress, and none is told.
  const auto far = deformed(v, [](const Vec3& X) { return Vec3(1.8 * X.x(), X.y(), X.z()); });
  const SkinStrain all = skin_strain(v, far, *body);
  EXPECT_NEAR(all.beyond_law_mm2, all.area_mm2, 1e-9);
  EXPECT_EQ(all.stress_max_kPa, 0);
  EXPECT_NEAR(all.stretch_max, 1.8, 1e-5);
  // Crushed to a third in its plane, so threefold thick.
  const auto thick = deformed(v, [](const Vec3& X) { return Vec3(X.x() / 3, X.y(), X.z()); });
  EXPECT_NEAR(skin_strain(v, thick, *body).beyond_law_mm2, all.area_mm2, 1e-9);
}

TEST(SkinStrain, TheLargestIsThatOfMoreThanASquareMm) {
  const auto body = measured_block({40, 40, 5}, 1, skin_material());
  const SurfaceView v = view_of(*body);
  auto x = deformed(v, [](const Vec3& X) { return Vec3(X.x() > 10 ? 1.2 * X.x() - 2 : X.x(), X.y(), X.z()); });
  EXPECT_NEAR(skin_strain(v, x, *body).stretch_max, 1.2, 1e-5);
  // Half a square mm at the corner of the block, drawn out.
  for (size_t i = 0; i < x.size(); ++i)
    if (v.X_mm[i] == Vec3(-20, -20, 0)) x[i] += Vec3f(-0.3f, -0.3f, 0);
  EXPECT_LT(skin_strain(v, x, *body).stretch_max, 1.21);
}

TEST(SkinStrain, PercentilesAreByArea) {
  std::vector<std::pair<double, double>> p{{3, 1}, {1, 98}, {2, 1}};
  EXPECT_EQ(weighted_percentile(p, 0.5), 1);
  EXPECT_EQ(weighted_percentile(p, 0.98), 1);
  EXPECT_EQ(weighted_percentile(p, 0.985), 2);
  EXPECT_EQ(weighted_percentile(p, 1), 3);
  p.clear();
  EXPECT_EQ(weighted_percentile(p, 0.5), 0);
  // Half of the block stretched: the 95th percentile sees it, the 40th would not.
  const auto body = measured_block({20, 16, 5}, 1, skin_material());
  const SurfaceView v = view_of(*body);
  const auto x = deformed(v, [](const Vec3& X) { return Vec3(X.x() > 0 ? 1.2 * X.x() : X.x(), X.y(), X.z()); });
  EXPECT_NEAR(skin_strain(v, x, *body).stretch_p99, 1.2, 1e-6);
}

}  // namespace test_skin_strain
}  // namespace limberg
