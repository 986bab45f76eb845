// How a user adds a law: everything of it is in this file. First the energy in principal stretches (value and two
// derivatives), then its entry, then a scene that names it.
#include <gtest/gtest.h>

#include "app/scene/scene.h"
#include "sim/fem/materials/catalogue.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "sim/testing/reference_newton.h"

namespace limberg {
namespace test_own_law {

// Yeoh (1993): W = c1 x + c2 x^2 + c3 x^3 with x = s1^2 + s2^2 + s3^2 - 3.
struct Yeoh final : PrincipalEnergy {
  double c1, c2, c3;
  Yeoh(double a, double b, double c) : c1(a), c2(b), c3(c) {}
  PrincipalResponse at(const Vec3& s) const override {
    const double x = s.squaredNorm() - 3, w1 = c1 + 2 * c2 * x + 3 * c3 * x * x, w2 = 2 * c2 + 6 * c3 * x;
    return {c1 * x + c2 * x * x + c3 * x * x * x, 2 * w1 * s, 2 * w1 * Mat3::Identity() + 4 * w2 * s * s.transpose()};
  }
  std::string describe() const override { return "Yeoh"; }
};

LawPtr yeoh_law(double c1, double c2, double c3) {
  return std::make_shared<Isotropic>(std::make_shared<Yeoh>(c1, c2, c3));
}

LawCatalogue::Entry yeoh() {
  return {"yeoh",
          "c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3",
          {{"c1_kPa", 0, 1e6, true}, {"c2_kPa", 0, 1e6}, {"c3_kPa", 0, 1e6}},
          [](const LawCatalogue::Values& v) {
            return LayerLaw{0, yeoh_law(v.number("c1_kPa"), v.number("c2_kPa"), v.number("c3_kPa")), 8};
          }};
}

/// The same law written a second time, by another formula and without stretches: dx/dF = 2 F.
struct YeohOfF final : MaterialLaw {
  double c1, c2, c3;
  YeohOfF(double a, double b, double c) : c1(a), c2(b), c3(c) {}
  Response at(const Mat3& F) const override {
    const double x = F.squaredNorm() - 3;
    return {x * (c1 + x * (c2 + x * c3)), (2 * c1 + 4 * c2 * x + 6 * c3 * x * x) * F};
  }
  Mat9 tangent_kPa(const Mat3& F, bool) const override {
    const double x = F.squaredNorm() - 3;
    const Eigen::Map<const Eigen::Matrix<double, 9, 1>> f(F.data());
    return (2 * c1 + 4 * c2 * x + 6 * c3 * x * x) * Mat9::Identity() + (8 * c2 + 24 * c3 * x) * f * f.transpose();
  }
  std::string describe() const override { return "Yeoh, written a second time"; }
};

/// How far the force on what is held differs from that of the reference, in double and with this law: relative.
double off_the_law(const World& world, const LawPtr& law) {
  FemModel m = world.skin()->solver().model();
  m.laws.assign(1, law);
  std::vector<Vec3> u, g;
  for (const Vec3f& v : world.skin()->solver().displacement_mm()) u.push_back(v.cast<double>());
  ReferenceElasticity(m, {}).gradient(u, g);
  Vec3 held = Vec3::Zero();
  for (size_t i = 0; i < g.size(); ++i)
    if (m.fixed[i]) held -= g[i];
  return (world.skin()->solver().support_force_mN() - held).norm() / held.norm();
}

TEST(OwnLaw, EnergyStressAndTangentAreThoseOfTheFormula) {
  const LawPtr law = yeoh_law(10, 30, 5), other = std::make_shared<YeohOfF>(10, 30, 5);
  Mat3 shear = Mat3::Identity(), pulled = Vec3(1.5, 0.9, 0.75).asDiagonal();
  shear(0, 1) = 0.6, shear(2, 0) = -0.3;
  for (const Mat3& F : {Mat3(Mat3::Identity()), shear, pulled, Mat3(shear * pulled)}) {
    const MaterialLaw::Response a = law->at(F), b = other->at(F);
    EXPECT_NEAR(a.energy_kPa, b.energy_kPa, 1e-9);
    EXPECT_LT((a.P_kPa - b.P_kPa).norm(), 1e-9);
    EXPECT_LT((law->tangent_kPa(F, false) - other->tangent_kPa(F, false)).norm(), 1e-7);
  }
}

/// A block of 24 x 20 x 6 mm with these layers.
std::string block_scene(const std::string& layers) {
  return "[body]\nsource = \"block\"\nsize_mm = [24, 20, 6]\nskin_cell_mm = 2\n" + layers + "[lattice]\ncell_mm = 3\n";
}

/// A hook pulls it, and it comes to rest.
void pull(World& world, const StepSettings& s) {
  EXPECT_TRUE(world.apply(SetHook{1, {2, 1}}).done);
  EXPECT_TRUE(world.apply(MoveHook{1, {2, 3, 6}, 0}).done);
  EXPECT_LE(world.step(s).residual, 1e-5);
}

TEST(OwnLaw, RunsThroughAScene) {
  auto laws = std::make_shared<LawCatalogue>(*shipped_laws());
  laws->add(yeoh());
  const std::string text = block_scene(R"([[layer]]
name = "skin"
thickness_mm = 1.5
law = "yeoh"
c1_kPa = 10
c2_kPa = 30
c3_kPa = 5
poisson = 0.48
prestretch_along = 1.1
[[layer]]
name = "fat"
thickness_mm = 4.5
young_kPa = 12
poisson = 0.45
)");
  const Scene scene = parse_scene(text, "own.toml", laws);
  EXPECT_NEAR(scene.layers()[0].material.mu_kPa(), 20, 1e-9);  // 2 c1
  const LawPtr formula = std::make_shared<YeohOfF>(10, 30, 5);
  InlineWorkers workers;
  World world(world_spec(scene, build_body(scene)), workers);
  ASSERT_EQ(world.skin()->solver().model().laws.size(), 1u);
  // A hook pulls it, an incision opens it, and undo brings the pulled state back to the bit.
  StepSettings s;
  s.max_iterations = 300, s.tolerance = 1e-5;
  pull(world, s);
  const uint64_t pulled = world.state_hash();
  EXPECT_LT(off_the_law(world, formula), 1e-3) << "the engine's forces are those of the reference in double";
  EXPECT_GT(off_the_law(world, std::make_shared<YeohOfF>(10, 30.6, 5)), 1e-3) << "a constant 2 % off is seen";
  EXPECT_TRUE(world.apply(Incise{{{-5, -2}, {6, -2}}, 4}).done);
  EXPECT_LE(world.step(s).residual, 1e-5);
  EXPECT_EQ(world.skin()->solver().model().laws.size(), 1u);
  EXPECT_LT(off_the_law(world, formula), 1e-3) << "after the cut too";
  EXPECT_NE(world.state_hash(), pulled);
  EXPECT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.state_hash(), pulled);
}

TEST(OwnLaw, NamesAndConstantsAreChecked) {
  LawCatalogue laws = *shipped_laws();
  laws.add(yeoh());
  EXPECT_THROW(laws.add(yeoh()), std::exception);
  Material m;
  m.law = {"yeoh", {{"c1_kPa", {10}}, {"c2_kPa", {1}}}};
  EXPECT_THROW(layer_response(m, &laws), std::exception);  // c3 is missing
  m.law.constants.push_back({"c3_kPa", {0}});
  EXPECT_NEAR(layer_response(m, &laws).mu_kPa, 20, 1e-9);
  EXPECT_THROW(layer_response(m), std::exception);  // the shipped laws do not know it
}

/// lambda of its own for nu = .45 is 9 mu.
LawCatalogue::Entry with_volume(bool says_so, double lambda_over_mu) {
  return {"with-volume", "neo-Hookean with ln J", {{"mu_kPa", 0, 1e6, true}}, [=](const LawCatalogue::Values& v) {
            const double mu = v.number("mu_kPa");
            return LayerLaw{0, neo_hookean_log_full(mu, lambda_over_mu * mu), 8, says_so};
          }};
}

TEST(OwnLaw, OneThatHoldsItsVolumeHasNoneAddedByTheCell) {
  Material m;
  m.law = {"with-volume", {{"mu_kPa", {20}}}};
  const auto response = [&](bool says_so, double poisson) {
    LawCatalogue laws = *shipped_laws();
    laws.add(with_volume(says_so, 9));
    m.poisson = poisson;
    return layer_response(m, &laws);
  };
  EXPECT_EQ(response(true, 0.45).lambda_kPa, 0);
  EXPECT_NEAR(response(true, 0.45).mu_kPa, 20, 1e-9);
  for (const double poisson : {0.3, 0.44, 0.46, 0.49})
    EXPECT_THROW(response(true, poisson), InputError) << "a ratio that is not the law's own: " << poisson;
  for (const double poisson : {0.45, 0.46, 0.49})
    EXPECT_THROW(response(false, poisson), InputError) << "50 kPa on top at .46 otherwise";
  // A law of shape alone is not complete.
  LawCatalogue laws = *shipped_laws();
  LawCatalogue::Entry wrong = yeoh();
  wrong.make = [](const LawCatalogue::Values&) { return LayerLaw{0, yeoh_law(10, 0, 0), 8, true}; };
  laws.add(wrong);
  m.law = {"yeoh", {{"c1_kPa", {10}}, {"c2_kPa", {0}}, {"c3_kPa", {0}}}};
  EXPECT_THROW(layer_response(m, &laws), InputError);
}

TEST(OwnLaw, OneThatHoldsItsVolumeRunsThroughAScene) {
  auto laws = std::make_shared<LawCatalogue>(*shipped_laws());
  laws->add(with_volume(true, 9));
  const std::string text = block_scene(R"([[layer]]
name = "skin"
thickness_mm = 6
law = "with-volume"
mu_kPa = 20
poisson = 0.45
)");
  const Scene scene = parse_scene(text, "own.toml", laws);
  InlineWorkers workers;
  World world(world_spec(scene, build_body(scene)), workers);
  StepSettings s;
  s.max_iterations = 500, s.tolerance = 1e-5;
  pull(world, s);
  EXPECT_LT(off_the_law(world, neo_hookean_log_full(20, 180)), 1e-3);
  EXPECT_GT(off_the_law(world, neo_hookean_log_full(20, 230)), 1e-3) << "50 kPa more are seen";
}

}  // namespace test_own_law
}  // namespace limberg
