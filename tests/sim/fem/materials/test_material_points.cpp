// Cells that carry laws: float engine, double reference and the exact quadratic stencil against each other.
#include <gtest/gtest.h>

#include "../models.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/model/box_model.h"
#include "sim/testing/reference_newton.h"

namespace limberg {
namespace test_material_points {

using test::Random;

FemModel box_of(const LawPtr& law, double lambda_kPa, const Mat3& M = Mat3::Identity(), Int3 cells = {3, 2, 2}) {
  BoxSpec b;
  b.cells = cells;
  b.size_mm = {9, 7, 5};
  b.fix_bottom = true;
  FemModel m = box_model(b);
  m.laws = {law};
  for (Stencil& s : m.stencils) s = fem::law_stencil(m.cell_mm, 0, *law, lambda_kPa, 1e-6, M);
  return m;
}

Mat3 prestretch() { return Vec3(1.15, 1.05, 1 / (1.15 * 1.05)).asDiagonal(); }

// Eight Gauss points integrate the quadratic energy exactly: the same element as the stencil of fem_model.h.
TEST(MaterialPoints, NeoHookeanPointsEqualTheExactStencil) {
  const Elastic e = elastic_from_young(60, 0.45);
  FemModel points = box_of(neo_hookean(e.mu_kPa), e.lambda_kPa, prestretch());
  FemModel stencil = points;
  stencil.laws.clear();
  for (Stencil& s : stencil.stencils) s = box_stencil(stencil.cell_mm, e, 1e-6, prestretch());
  EXPECT_NEAR(points.stencils[0].p0_kPa, stencil.stencils[0].p0_kPa, 1e-12);
  const auto u = test::random_displacement(points, 0.5, 3);
  const ReferenceElasticity a(points, {}), b(stencil, {});
  std::vector<Vec3> ga, gb;
  const double ea = a.gradient(u, ga), eb = b.gradient(u, gb);
  EXPECT_NEAR(ea, eb, 1e-10 * std::fabs(eb));
  double size = 0;
  for (const Vec3& g : gb) size = std::max(size, g.norm());
  for (size_t i = 0; i < ga.size(); ++i) EXPECT_LT((ga[i] - gb[i]).norm(), 1e-12 * size);
}

std::vector<std::pair<const char*, LawPtr>> laws() {
  return {{"Ogden", ogden({{3, 9}, {-1, -4}})},
          {"Mooney-Rivlin", mooney_rivlin(6, 4)},
          {"StVK", st_venant_kirchhoff(20)},
          {"skin", sum_of({neo_hookean(20), dispersed_fibres({50, 1.5, 0.15}, {{{1, 1, 0}}, {{1, -1, 0}}})})}};
}

TEST(MaterialPoints, ReferenceGradientAndHessianAreDerivatives) {
  for (const auto& [name, law] : laws()) {
    const FemModel m = box_of(law, 200, prestretch());
    const ReferenceElasticity e(m, {});
    const auto u = test::random_displacement(m, 0.3, 1);
    std::vector<Vec3> g, g1, g0;
    e.gradient(u, g);
    const Eigen::MatrixXd H = e.dense_hessian(u, false);
    Random r(2);
    for (int k = 0; k < 4; ++k) {
      std::vector<Vec3> d(u.size()), p = u, q = u;
      Eigen::VectorXd dv(3 * Eigen::Index(u.size()));
      double exact = 0;
      const double h = 1e-5;
      for (size_t i = 0; i < d.size(); ++i) {
        d[i] = r.vector(1), exact += g[i].dot(d[i]);
        p[i] += h * d[i], q[i] -= h * d[i];
        dv.segment<3>(3 * Eigen::Index(i)) = d[i];
      }
      const double found = (e.gradient(p, g1) - e.gradient(q, g0)) / (2 * h);
      EXPECT_NEAR(found, exact, 1e-6 * (std::fabs(exact) + 1000)) << name;
      const Eigen::VectorXd Hd = H * dv;
      double error = 0;
      for (size_t i = 0; i < d.size(); ++i)
        error = std::max(error, ((g1[i] - g0[i]) / (2 * h) - Hd.segment<3>(3 * Eigen::Index(i))).norm());
      EXPECT_LT(error, 1e-6 * Hd.norm()) << name;
    }
  }
}

TEST(MaterialPoints, FloatEngineFindsTheEquilibriumOfTheReference) {
  for (const auto& [name, law] : laws()) {
    const FemModel m = box_of(law, 200, prestretch());
    Spring hook;
    hook.id = 1, hook.to_world = true, hook.a = embed(m, {1, 1, 5}), hook.target_mm = {3, 2, 9}, hook.k_N_per_mm = 0.3;
    const ReferenceElasticity reference(m, std::span(&hook, 1));
    const auto exact = reference.solve(std::vector<Vec3>(m.X_mm.size(), Vec3::Zero()), {});
    ASSERT_LT(exact.residual, 1e-10) << name;
    InlineWorkers one;
    test::ThreadWorkers two(2);
    std::vector<Vec3f> first;
    for (Workers* w : {static_cast<Workers*>(&one), static_cast<Workers*>(&two)}) {
      auto solver = make_solver(*w);
      solver->set_model(std::make_shared<FemModel>(m), {});
      solver->set_springs(std::span(&hook, 1));
      StepSettings s;
      s.max_iterations = 400, s.tolerance = 1e-6;
      solver->step(s);
      double error = 0;
      for (size_t i = 0; i < exact.u.size(); ++i)
        error = std::max(error, (solver->displacement_mm()[i].cast<double>() - exact.u[i]).norm());
      // The hook and the supports balance: the material's forces are inside.
      const Vec3 hook_mN = solver->spring_force_mN(1);
      EXPECT_LT((solver->support_force_mN() - hook_mN).norm(), 1e-3 * hook_mN.norm()) << name;
      EXPECT_LT(error, 0.002) << name;  // a residual of 1e-6 in single precision; the box is 9 mm
      const std::vector<Vec3f> u(solver->displacement_mm().begin(), solver->displacement_mm().end());
      if (first.empty()) first = u;
      EXPECT_EQ(0, std::memcmp(first.data(), u.data(), u.size() * sizeof(Vec3f))) << name;
    }
  }
}

// A prestretched flat piece under a free surface is at rest, whatever its law.
TEST(MaterialPoints, PrestretchedSkinRests) {
  for (const auto& [name, law] : laws()) {
    FemModel m = box_of(law, 200, prestretch());
    for (size_t i = 0; i < m.fixed.size(); ++i)
      m.fixed[i] = std::fabs(std::fabs(m.X_mm[i][0]) - 4.5) < 1e-9 || std::fabs(std::fabs(m.X_mm[i][1]) - 3.5) < 1e-9;
    std::vector<Vec3> g;
    ReferenceElasticity(m, {}).gradient(std::vector<Vec3>(m.X_mm.size(), Vec3::Zero()), g);
    for (size_t i = 0; i < g.size(); ++i)
      if (!m.fixed[i]) {
        EXPECT_LT(g[i].norm(), 1e-9) << name;
      }
  }
}

// Uniaxial tension of a nearly incompressible block, ends sliding: one homogeneous state, known in closed form.
TEST(MaterialPoints, HomogeneousTensionOfEveryLaw) {
  struct Case {
    const char* name;
    LawPtr law;
    std::function<double(double)> cauchy_kPa;  // incompressible
  };
  const double l = 1.4;
  const std::vector<Case> cases = {
      {"neo-Hookean", neo_hookean(20), [](double s) { return 20 * (s * s - 1 / s); }},
      {"Mooney-Rivlin", mooney_rivlin(6, 4), [](double s) { return 2 * (6 + 4 / s) * (s * s - 1 / s); }},
      {"Ogden", ogden({{3, 9}, {-1, -4}}),
       [](double s) { return 3 * (std::pow(s, 9) - std::pow(s, -4.5)) - (std::pow(s, -4) - std::pow(s, 2)); }}};
  for (const Case& c : cases) {
    FemModel m = box_of(c.law, 20 * 2e4);  // nu about .49998: lateral contraction within 1e-4 of incompressible
    m.fixed.assign(m.fixed.size(), 0);
    // Stiff springs to world would bend the corners; instead the exact field is imposed and the ends' force is read.
    const double t = 1 / std::sqrt(l);
    std::vector<Vec3> u(m.X_mm.size());
    double best = 1e300, area_force = 0;
    // The volume change that balances the sides: one unknown, found by bisection on the lateral force.
    double lo = -1e-3, hi = 1e-3;
    for (int k = 0; k < 100; ++k) {
      const double e = 0.5 * (lo + hi);
      for (size_t i = 0; i < u.size(); ++i)
        u[i] = Vec3((l - 1) * m.X_mm[i][0], (t * (1 + e) - 1) * m.X_mm[i][1], (t * (1 + e) - 1) * m.X_mm[i][2]);
      std::vector<Vec3> g;
      ReferenceElasticity(m, {}).gradient(u, g);
      double side = 0;
      area_force = 0;
      for (size_t i = 0; i < g.size(); ++i) {
        if (m.X_mm[i][1] > 3.49) side += g[i][1];
        if (m.X_mm[i][0] > 4.49) area_force += g[i][0];
      }
      best = side;
      (side > 0 ? hi : lo) = e;
    }
    EXPECT_NEAR(best, 0, 1e-3 * std::fabs(area_force)) << c.name;
    const double sigma = area_force / (7 * 5 * t * t);
    EXPECT_NEAR(sigma, c.cauchy_kPa(l), 2e-3 * c.cauchy_kPa(l)) << c.name;
  }
}

}  // namespace test_material_points
}  // namespace limberg
