// The lattice's fields against closed forms of homogeneous states.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/workers.h"
#include "sim/measure/lattice_fields.h"
#include "sim/measure/skin_strain.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_lattice_fields {

constexpr double kAlong = 1.12, kAcross = 1.05;

WorldSpec one_layer(const LawSpec& law = {}) {
  WorldSpec spec = test::small_block({.along = kAlong, .across = kAcross, .fat = false});
  if (law.name.empty()) return spec;
  auto body = std::make_shared<Body>(*spec.body);
  body->layers[0].material.law = law;
  spec.body = body;
  return spec;
}

/// mu and the lambda of fem_model.h.
struct Constants {
  double mu, lambda;
};
Constants constants(const Material& m) { return {m.mu_kPa(), m.lambda_kPa() + m.mu_kPa()}; }

TEST(LatticeFields, APrestretchedLayerAtRestHasItsStress) {
  InlineWorkers w;
  const World world(one_layer(), w);
  const LatticeFields f = lattice_fields(*world.skin());
  const double mu = constants(world.skin()->spec().body->layers[0].material).mu;
  // sigma = mu A - p0 with p0 = mu A_nn: nothing presses on the free surface.
  const double nn = 1 / (kAlong * kAcross * kAlong * kAcross);
  const double xx = mu * (kAlong * kAlong - nn), yy = mu * (kAcross * kAcross - nn);
  ASSERT_GT(f.node.size(), 100u);
  for (size_t c = 0; c < f.node.size(); ++c) {
    EXPECT_NEAR(f.stress_kPa[c][0], xx, 1e-4 * xx);
    EXPECT_NEAR(f.stress_kPa[c][1], yy, 1e-4 * xx);
    for (const size_t k : {2, 3, 4, 5}) EXPECT_NEAR(f.stress_kPa[c][k], 0, 1e-4 * xx);
    EXPECT_NEAR(f.pressure_kPa[c], -(xx + yy) / 3, 1e-4 * xx);
    EXPECT_NEAR(f.stretch[c], kAlong, 1e-6);
    EXPECT_EQ(f.material[c], 0);
  }
}

/// All that is held goes where a homogeneous state with a free surface has it; the rest follows by itself.
void pull(World& world, double along, double across, double thick) {
  world.hold_at([=](const Vec3& X) { return Vec3(along * X.x(), across * X.y(), thick * X.z()); });
  StepSettings s;
  s.max_iterations = 50, s.tolerance = 2e-6;
  for (int i = 0; i < 60; ++i)
    if (world.step(s).residual <= s.tolerance) break;
}

TEST(LatticeFields, AStretchedLayerHasTheStressOfTheMembrane) {
  InlineWorkers w;
  World world(one_layer(), w);
  const auto [mu, lambda] = constants(world.skin()->spec().body->layers[0].material);
  const double a = 1.1, b = 0.97, nn = 1 / (kAlong * kAcross * kAlong * kAcross);
  // sigma_nn = 0 for the stretch of the thickness (skin_strain.h).
  const double s = (mu * nn + lambda) / (mu * nn / (a * b) + lambda * a * b);
  pull(world, a, b, s);
  const LatticeFields f = lattice_fields(*world.skin());
  const double J = a * b * s, p = lambda * (J - 1) - mu * nn;
  const double xx = mu / J * a * a * kAlong * kAlong + p, yy = mu / J * b * b * kAcross * kAcross + p;
  for (size_t c = 0; c < f.node.size(); ++c) {
    EXPECT_NEAR(f.stress_kPa[c][0], xx, 2e-3 * xx);
    EXPECT_NEAR(f.stress_kPa[c][1], yy, 2e-3 * xx);
    EXPECT_NEAR(f.stress_kPa[c][2], 0, 2e-3 * xx);
    EXPECT_NEAR(f.stretch[c], a * kAlong, 1e-3);
  }
  // The membrane's own figure, made from the surface alone.
  Snapshot now;
  world.fill(now);
  for (const MembraneState& m : skin_states(now.topology->view, now.x_mm, *world.skin()->spec().body))
    if (m.area_mm2 > 0) {
      EXPECT_NEAR(m.stress_kPa, xx, 2e-3 * xx);
    }
}

// A law of its own has no K: what its points give alone.
TEST(LatticeFields, ALawOfItsOwnCountsByItsPoints) {
  InlineWorkers w;
  World world(one_layer({"mooney-rivlin", {{"c10_kPa", {6}}, {"c01_kPa", {4}}}}), w);
  double across = 0;
  const LatticeFields f = lattice_fields(*world.skin());
  // Principal Cauchy stresses at rest differ by s dW/ds: 2 (l_1^2 - l_3^2) (c10 + c01 l_2^2), J = 1.
  const double l1 = kAlong, l2 = kAcross, l3 = 1 / (kAlong * kAcross);
  const double xx = 2 * (l1 * l1 - l3 * l3) * (6 + 4 * l2 * l2), yy = 2 * (l2 * l2 - l3 * l3) * (6 + 4 * l1 * l1);
  for (size_t c = 0; c < f.node.size(); ++c) {
    EXPECT_NEAR(f.stress_kPa[c][0], xx, 1e-3 * xx);
    EXPECT_NEAR(f.stress_kPa[c][1], yy, 1e-3 * xx);
    across = std::max(across, std::abs(double(f.stress_kPa[c][2])));
  }
  EXPECT_LT(across, 1e-3 * xx);
}

// What a cut divides is there once for each piece, with nodes of its own.
TEST(LatticeFields, CopiesOfACellHaveTheirShares) {
  InlineWorkers w;
  World world(one_layer(), w);
  const size_t before = lattice_fields(*world.skin()).node.size();
  ASSERT_TRUE(world.apply(Excise{{{-8, -8}, {8, -8}, {8, 8}, {-8, 8}}, 7, true}).done);
  const LatticeFields f = lattice_fields(*world.skin());
  EXPECT_NE(f.node.size(), before);
  double mm3 = 0;
  const FemModel& m = world.skin()->solver().model();
  for (const float share : f.fraction) mm3 += double(share) * m.cell_mm.prod();
  // Shares are floored for conditioning (HexCell::scale): a little more than there is.
  EXPECT_NEAR(mm3, world.skin()->volume_mm3(), 2e-3 * mm3);
}

}  // namespace test_lattice_fields
}  // namespace limberg
