// Every law against finite differences and closed forms, and against what any hyperelastic law must satisfy.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "../models.h"
#include "sim/base/error.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/materials/limited.h"
#include "sim/fem/materials/muscle.h"

namespace limberg {
namespace test_laws {

using test::Random;

struct Named {
  const char* name;
  LawPtr law;
  bool isotropic = true;
};

std::vector<Named> laws() {
  const double c = std::cos(0.7), s = std::sin(0.7);
  const LawPtr fibres = dispersed_fibres({50, 1.5, 0.15}, {{{c, s, 0}}, {{c, -s, 0}}});
  return {{"neo-Hookean", neo_hookean(20)},
          {"neo-Hookean ln J", neo_hookean_log_full(20, 60)},
          {"neo-Hookean isochoric", neo_hookean_isochoric_full(20, 90)},
          {"Mooney-Rivlin", mooney_rivlin(6, 4)},
          {"Ogden", ogden({{3, 9}, {-1, -4}})},
          {"corotated", corotated(20)},
          {"corotated full", corotated_full(20, 60)},
          {"StVK", st_venant_kirchhoff(20)},
          {"StVK full", st_venant_kirchhoff_full(20, 60)},
          {"limits", stretch_limits(0.7, 1.3, 400)},
          {"fibres", fibres, false},
          {"fibres in a matrix", sum_of({neo_hookean(20), fibres}), false},
          {"active fibres", active_fibres(100, 0.4, {c, s, 0.3}), false}};
}

Mat3 random_matrix(Random& r, double size) {
  Mat3 m;
  for (int j = 0; j < 3; ++j) m.col(j) = r.vector(size);
  return m;
}

Mat3 random_rotation(Random& r) {
  return Eigen::Quaterniond(r.uniform(), r.uniform(), r.uniform(), r.uniform()).normalized().toRotationMatrix();
}

/// Near rest, strongly deformed, squeezed nearly flat, inverted.
std::vector<Mat3> deformations() {
  Random r(11);
  std::vector<Mat3> f;
  for (int k = 0; k < 6; ++k) {
    f.push_back(Mat3::Identity() + random_matrix(r, 0.1));
    f.push_back(Mat3::Identity() + random_matrix(r, 0.5));
    const Mat3 U = random_rotation(r), V = random_rotation(r);
    f.push_back(U * Vec3(1.4, 0.9, 0.12).asDiagonal() * V.transpose());
    f.push_back(U * Vec3(1.4, 0.9, -0.12).asDiagonal() * V.transpose());
    f.push_back(U * Vec3(1.2, 0.8, -0.5).asDiagonal() * V.transpose());
    f.push_back(U * Vec3(1.6, 0.31, 0.2).asDiagonal() * V.transpose());
  }
  return f;
}

TEST(RotationSvd, ReassemblesAndRotates) {
  Random r(3);
  std::vector<Mat3> all = deformations();
  for (int k = 0; k < 100; ++k) all.push_back(random_matrix(r, std::pow(10.0, 3 * r.uniform())));
  all.push_back(Mat3::Zero());
  all.push_back(Mat3::Identity());
  all.push_back(-Mat3::Identity());
  all.push_back(Vec3(1, -2, 3) * Vec3(0.5, 0, 1).transpose());                                               // a line
  all.push_back(Vec3(1, -2, 3) * Vec3(0.5, 0, 1).transpose() + Vec3(0, 1, 3) * Vec3(-1, 4, 1).transpose());  // a plane
  for (const Mat3& F : all) {
    const RotationSvd d = rotation_svd(F);
    const double size = std::max(F.norm(), 1e-300);
    EXPECT_LT((d.U * d.s.asDiagonal() * d.V.transpose() - F).norm(), 1e-14 * 20 * size);
    EXPECT_LT((d.U.transpose() * d.U - Mat3::Identity()).norm(), 1e-14);
    EXPECT_LT((d.V.transpose() * d.V - Mat3::Identity()).norm(), 1e-14);
    EXPECT_NEAR(d.U.determinant(), 1, 1e-13);
    EXPECT_NEAR(d.V.determinant(), 1, 1e-13);
    EXPECT_GE(d.s[0], d.s[1]);
    EXPECT_GE(d.s[1], std::fabs(d.s[2]) - 1e-15 * size);
    if (std::fabs(F.determinant()) > 1e-12 * size * size * size) {
      EXPECT_EQ(d.s[2] < 0, F.determinant() < 0);
    }
  }
}

TEST(Laws, RestIsFreeOfEnergyAndTurningCostsNothing) {
  Random r(5);
  for (const Named& n : laws()) {
    EXPECT_NEAR(n.law->at(Mat3::Identity()).energy_kPa, 0, 1e-12) << n.name;
    for (const Mat3& F : deformations()) {
      const Mat3 Q = random_rotation(r);
      const auto a = n.law->at(F), b = n.law->at(Q * F);
      EXPECT_NEAR(a.energy_kPa, b.energy_kPa, 1e-11 * (1 + std::fabs(a.energy_kPa))) << n.name;
      EXPECT_LT((Q * a.P_kPa - b.P_kPa).norm(), 1e-10 * (1 + a.P_kPa.norm())) << n.name;
      if (n.isotropic) {
        EXPECT_NEAR(a.energy_kPa, n.law->at(F * Q).energy_kPa, 1e-11 * (1 + std::fabs(a.energy_kPa))) << n.name;
      }
    }
  }
}

TEST(Laws, StressIsTheDerivativeOfTheEnergy) {
  Random r(6);
  for (const Named& n : laws())
    for (const Mat3& F : deformations()) {
      const Mat3 D = random_matrix(r, 1);
      const double h = 1e-5, exact = n.law->at(F).P_kPa.cwiseProduct(D).sum();
      const double found = (n.law->at(F + h * D).energy_kPa - n.law->at(F - h * D).energy_kPa) / (2 * h);
      // Central difference: error h^2 times a third derivative (steep
      // laws: 1e4 times the stress) plus 1e-16/h of the energy.
      EXPECT_NEAR(found, exact, 2e-6 * (1 + n.law->at(F).P_kPa.norm())) << n.name << "\n" << F;
    }
}

TEST(Laws, TangentIsTheDerivativeOfTheStress) {
  Random r(7);
  for (const Named& n : laws())
    for (const Mat3& F : deformations()) {
      if (!n.isotropic && std::string(n.name) == "fibres" && n.law->at(F).energy_kPa == 0) continue;
      const Mat9 C = n.law->tangent_kPa(F, false);
      EXPECT_LT((C - C.transpose()).norm(), 1e-10 * (1 + C.norm())) << n.name;
      const Mat3 D = random_matrix(r, 1);
      const double h = 1e-5;
      const Mat3 found = (n.law->at(F + h * D).P_kPa - n.law->at(F - h * D).P_kPa) / (2 * h);
      const Eigen::Matrix<double, 9, 1> exact = C * Eigen::Map<const Eigen::Matrix<double, 9, 1>>(D.data());
      const Eigen::Map<const Eigen::Matrix<double, 9, 1>> f(found.data());
      EXPECT_LT((f - exact).norm(), 1e-5 * (1 + C.norm())) << n.name << "\n" << F;
    }
}

TEST(Laws, ProjectedTangentHasNoNegativeEigenvalue) {
  for (const Named& n : laws())
    for (const Mat3& F : deformations()) {
      const Mat9 C = n.law->tangent_kPa(F, true);
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Mat9>(C).eigenvalues()[0], -1e-10 * (1 + C.norm())) << n.name;
    }
}

// The promise for inversion: a cell turned inside out is pushed back. (Energies that are even in every stretch, as I1
// is, cannot know; there the element's volume term does it.)
TEST(Laws, AnInvertedCellIsPushedBack) {
  for (const LawPtr& law : {ogden({{3, 9}, {-1, -4}}), corotated(20), corotated_full(20, 60),
                            neo_hookean_log_full(20, 60), neo_hookean_isochoric_full(20, 90)})
    for (const double s : {0.25, 0.05, -0.05, -0.5, -1.0, -3.0}) {
      const Mat3 F = Vec3(1, 1, s).asDiagonal();
      EXPECT_LT(law->at(F).P_kPa(2, 2), 0) << law->describe() << " " << s;  // dW/ds < 0: pushes s up
    }
}

// --- Homogeneous states of an incompressible block: sigma = P F^T - p I, p from the free sides.
// ------------------------

double cauchy(const MaterialLaw& law, const Vec3& stretch, int axis, int free_axis) {
  const Mat3 F = stretch.asDiagonal();
  const Mat3 sigma = law.at(F).P_kPa * F.transpose();
  return sigma(axis, axis) - sigma(free_axis, free_axis);
}

TEST(HomogeneousStates, NeoHookean) {  // in units of mu
  const LawPtr law = neo_hookean(1);
  for (double l : {1.2, 1.5, 2.0}) {
    EXPECT_NEAR(cauchy(*law, {l, 1 / std::sqrt(l), 1 / std::sqrt(l)}, 0, 2), l * l - 1 / l, 1e-12);
    EXPECT_NEAR(cauchy(*law, {l, l, 1 / (l * l)}, 0, 2), l * l - std::pow(l, -4), 1e-12);
    EXPECT_NEAR(cauchy(*law, {l, 1, 1 / l}, 0, 2), l * l - 1 / (l * l), 1e-12);
  }
  Mat3 F = Mat3::Identity();
  F(0, 1) = 0.7;
  const Mat3 sigma = law->at(F).P_kPa * F.transpose();
  EXPECT_NEAR(sigma(0, 1), 0.7, 1e-12);
  EXPECT_NEAR(sigma(0, 0) - sigma(1, 1), 0.49, 1e-12);
}

// Within its limits a law with limits adds nothing; beyond them the nominal stress grows by limit_kPa.
TEST(HomogeneousStates, LimitsOfStretch) {
  const LawPtr law = stretch_limits(0.8, 1.25, 400);
  EXPECT_EQ(law->at(Vec3(1.24, 0.81, 1.0).asDiagonal().toDenseMatrix()).P_kPa, Mat3(Mat3::Zero()));
  const Mat3 P = law->at(Vec3(1.35, 0.7, 1.0).asDiagonal().toDenseMatrix()).P_kPa;
  EXPECT_NEAR(P(0, 0), 40, 1e-12);
  EXPECT_NEAR(P(1, 1), -40, 1e-12);
  EXPECT_NEAR(P(2, 2), 0, 1e-12);
  EXPECT_NEAR(law->at(Vec3(1.35, 0.7, 1.0).asDiagonal().toDenseMatrix()).energy_kPa, 4, 1e-12);
  for (const auto& [least, most, k] : {std::array{1.0, 1.2, 1.0}, {0.8, 1.0, 1.0}, {0.0, 1.2, 1.0}, {0.8, 1.2, 0.0}})
    EXPECT_THROW(stretch_limits(least, most, k), InputError);
}

TEST(HomogeneousStates, MooneyRivlinAndOgden) {
  const double l = 1.7, c1 = 3, c2 = 2;
  EXPECT_NEAR(cauchy(*mooney_rivlin(c1, c2), {l, 1 / std::sqrt(l), 1 / std::sqrt(l)}, 0, 2),
              2 * (c1 + c2 / l) * (l * l - 1 / l), 1e-12);
  const std::vector<OgdenTerm> t = {{3, 9}, {-1, -4}};
  double expected = 0;
  for (const OgdenTerm& o : t) expected += o.mu_kPa * (std::pow(l, o.alpha) - std::pow(l, -o.alpha / 2));
  EXPECT_NEAR(cauchy(*ogden(t), {l, 1 / std::sqrt(l), 1 / std::sqrt(l)}, 0, 2), expected, 1e-10 * expected);
}

/// Uniaxial tension along x of an incompressible orthotropic
/// block: the lateral stretch along y that leaves y and z free.
std::pair<double, double> uniaxial(const MaterialLaw& law, double l) {
  double lo = 0.3 / l, hi = 1.2;
  for (int k = 0; k < 200; ++k) {
    const double m = 0.5 * (lo + hi);
    (cauchy(law, {l, m, 1 / (l * m)}, 1, 2) > 0 ? hi : lo) = m;
  }
  return {cauchy(law, {l, lo, 1 / (l * lo)}, 0, 2), lo};
}

// Human back skin (Ni Annaidh et al. 2012): mu 0.2014 MPa, k1 24.53 MPa,
// k2 0.1327, kappa 0.1404, fibres at 41 degrees to the Langer line.
// Stresses and lateral stretches computed independently (kPa here).
TEST(HomogeneousStates, SkinWithTwoFibreFamilies) {
  const double a = 41 * std::numbers::pi / 180;
  auto skin = [&](bool along) {
    const Vec3 d1 = along ? Vec3(std::cos(a), std::sin(a), 0) : Vec3(std::sin(a), std::cos(a), 0);
    return sum_of(
        {neo_hookean(201.4), dispersed_fibres({24530, 0.1327, 0.1404}, {{d1}, {d1.cwiseProduct(Vec3(1, -1, 1))}})});
  };
  struct Row {
    bool along;
    double stretch, stress_kPa, lateral;
  };
  for (const Row& r :
       {Row{true, 1.05, 84.584, 0.92912}, Row{true, 1.10, 343.830, 0.84134}, Row{true, 1.15, 1348.058, 0.76511},
        Row{true, 1.20, 3291.599, 0.72905}, Row{false, 1.05, 36.542, 0.95935}, Row{false, 1.10, 87.253, 0.91117},
        Row{false, 1.20, 386.346, 0.78324}, Row{false, 1.30, 2637.876, 0.67480}}) {
    const auto [stress, lateral] = uniaxial(*skin(r.along), r.stretch);
    EXPECT_NEAR(stress, r.stress_kPa, 2e-3 * r.stress_kPa)
        << r.along << " " << r.stretch;  // constants are given to 3-4 digits
    EXPECT_NEAR(lateral, r.lateral, 2e-4) << r.along << " " << r.stretch;
  }
}

TEST(HomogeneousStates, OneFibreFamilyAndItsSwitch) {
  const LawPtr along = sum_of({neo_hookean(10), dispersed_fibres({100, 1, 0.1}, {{Vec3::UnitX()}})});
  for (auto [l, stress] :
       {std::pair{1.05, 12.96555}, {1.1, 29.88648}, {1.2, 81.45616}, {1.3, 175.82198}, {1.5, 788.99019}}) {
    const double t = 1 / std::sqrt(l);
    EXPECT_NEAR(cauchy(*along, {l, t, t}, 0, 2), stress, 1e-6 * stress);
  }
  const LawPtr across = sum_of({neo_hookean(10), dispersed_fibres({100, 1, 0.1}, {{Vec3::UnitY()}})});
  for (auto [l, stress] : {std::pair{1.1, 3.00909}, {1.2, 6.06667}, {1.3, 9.20769}}) {
    const double t = 1 / std::sqrt(l);
    EXPECT_NEAR(cauchy(*across, {l, t, t}, 0, 2), stress, 2e-6 * stress);  // fibres slack: the matrix alone
  }
}

TEST(Laws, BadConstantsAreRefused) {
  EXPECT_THROW(neo_hookean(0), InputError);
  EXPECT_THROW(ogden({}), InputError);
  EXPECT_THROW(ogden({{1, -2}}), InputError);
  EXPECT_THROW(mooney_rivlin(0, 0), InputError);
  EXPECT_THROW(dispersed_fibres({1, 1, 0.4}, {{Vec3::UnitX()}}), InputError);
  EXPECT_THROW(dispersed_fibres({1, 1, 0.1}, {}), InputError);
  EXPECT_THROW(dispersed_fibres({1, 1, 0.1}, {{Vec3::Zero()}}), InputError);
}

}  // namespace test_laws
}  // namespace limberg
