// The stability suite: one case per family recovers, and a case that cannot recover is told so.
#include <gtest/gtest.h>

#include "tests/bench/bullet_peer.h"
#include "tests/bench/stability.h"
#include "tests/bench/stability_cases.h"

namespace limberg::bench {
namespace test_stability {

TEST(Stability, OneCaseOfEveryFamilyRecovers) {
  StabilitySettings s;
  s.quick = true;
  const Result r = stability(s);
  EXPECT_GE(r.rows.size(), 8u);
  for (const Row& row : r.rows) EXPECT_TRUE(row.pass) << row.name << ": " << row.settings;
  ASSERT_EQ(r.bars.size(), 1u);
  EXPECT_TRUE(r.bars[0].pass);
}

TEST(Stability, ThereAreAtLeastThirtyCasesAndNoTwoAlike) {
  const auto all = stability_cases(false);
  EXPECT_GE(all.size(), 30u);
  for (size_t i = 0; i < all.size(); ++i)
    for (size_t j = 0; j < i; ++j) EXPECT_FALSE(all[i].family == all[j].family && all[i].name == all[j].name);
}

TEST(Stability, BulletsLawIsTheDerivativeOfItsEnergyAndFreeOfStressAtRest) {
  const auto [mu, lambda] = bullet_constants(60, 0.45);
  const LawPtr law = bullet_law(mu, lambda);
  EXPECT_LT(law->at(Mat3::Identity()).P_kPa.norm(), 1e-9);
  EXPECT_NEAR(law->at(Mat3::Identity()).energy_kPa, 0, 1e-12);
  Mat3 F;
  F << 1.1, 0.2, -0.1, 0.05, 0.8, 0.3, -0.2, 0.1, 1.3;
  const auto r = law->at(F);
  const Mat9 H = law->tangent_kPa(F, false);
  const double h = 1e-6;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      Mat3 up = F, down = F;
      up(i, j) += h, down(i, j) -= h;
      const auto a = law->at(up), b = law->at(down);
      EXPECT_NEAR((a.energy_kPa - b.energy_kPa) / (2 * h), r.P_kPa(i, j), 1e-5);
      const Mat3 dP = (a.P_kPa - b.P_kPa) / (2 * h);
      for (int k = 0; k < 9; ++k) EXPECT_NEAR(H(k, 3 * j + i), dP.data()[k], 1e-4);
    }
  // Small strains: Young's modulus and Poisson's ratio come back.
  const Mat9 H0 = law->tangent_kPa(Mat3::Identity(), false);
  const double c11 = H0(0, 0), c12 = H0(0, 4);
  EXPECT_NEAR(c12 / (c11 + c12), 0.45, 1e-6);
}

TEST(Stability, FiveTetrahedraFillEveryCell) {
  const auto all = stability_cases(true);
  const FemModel twin = tet_twin(*all[0].model, 20, 200);
  double volume = 0, expected = 0;
  for (const HexCell& c : twin.cells) volume += twin.stencils[size_t(c.stencil)].volume_mm3;
  for (const HexCell& c : all[0].model->cells) expected += all[0].model->stencils[size_t(c.stencil)].volume_mm3;
  EXPECT_NEAR(volume, expected, 1e-9 * expected);
}

}  // namespace test_stability
}  // namespace limberg::bench
