// The energy of fem_model.h: reference and float kernel against finite differences, closed forms and each other.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "models.h"
#include "sim/fem/elements/element_system.h"
#include "sim/testing/reference_newton.h"

namespace limberg {
namespace test_elements {

using test::Random;

Mat3 skin_prestretch() {
  Mat3 F = Mat3::Identity();
  F(0, 0) = 1.2, F(1, 1) = 1.05, F(2, 2) = 1 / (1.2 * 1.05);
  const double c = std::cos(0.4), s = std::sin(0.4);
  Mat3 R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return R * F * R.transpose();
}

/// Two layers, the upper one prestretched, odd cell sizes and partly filled cells.
FemModel layered_model(double poisson = 0.45) {
  BoxSpec b;
  b.cells = {3, 4, 2};
  b.size_mm = {9, 10, 5};
  b.young_bottom_kPa = 18;
  b.poisson = poisson;
  b.fix_bottom = true;
  FemModel m = box_model(b);
  m.stencils[1] = box_stencil(m.cell_mm, elastic_from_young(60, poisson), 1e-6, skin_prestretch());
  m.stencils[0].sample = {0.4, 0.55, 0.7};  // as in a cell that two layers share
  m.stencils[1].sample = {0.5, 0.35, 0.6};
  m.stencils[1].slide_kPa = 0.7 * m.stencils[1].mu_kPa;  // layers share it, and lie askew
  m.stencils[1].slide_axes = Eigen::AngleAxisd(0.5, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  Random r(5);
  for (HexCell& c : m.cells) c.scale = float(0.6 + 0.4 * r.uniform());
  return m;
}

std::vector<Spring> some_springs(const FemModel& m) {
  Spring a, b;
  a.id = 1, a.a = embed(m, {1, 1, 5}), a.b = embed(m, {-2, 1, 5}), a.k_N_per_mm = 0.02, a.target_mm = {0.2, 0, -0.1};
  b.id = 2, b.a = embed(m, {2, -3, 4}), b.to_world = true, b.target_mm = {5, 1, 9}, b.k_N_per_mm = 0.03;
  Spring wide;
  wide.id = 3, wide.k_N_per_mm = 0.05;
  for (double x : {-2.0, 0.0, 2.5})
    wide.a_wide.push_back(embed(m, {x, 2, 5})), wide.b_wide.push_back(embed(m, {x, -2, 4}));
  wide.a_wide[0].share = -0.6, wide.b_wide[1].share = 3;
  return {a, b, wide};
}

TEST(Reference, GradientIsTheDerivativeOfTheEnergy) {
  const FemModel m = layered_model();
  const auto springs = some_springs(m);
  ReferenceElasticity e(m, springs);
  auto u = test::random_displacement(m, 0.4, 1);
  std::vector<Vec3> g;
  e.gradient(u, g);
  Random r(2);
  for (int k = 0; k < 10; ++k) {
    std::vector<Vec3> d(u.size());
    double exact = 0;
    for (size_t i = 0; i < d.size(); ++i) d[i] = r.vector(1), exact += g[i].dot(d[i]);
    const double h = 1e-5;  // cubic error term ~ h^2
    auto at = [&](double t) {
      auto v = u;
      for (size_t i = 0; i < v.size(); ++i) v[i] += t * d[i];
      return e.energy(v);
    };
    EXPECT_NEAR((at(h) - at(-h)) / (2 * h), exact, 1e-6 * std::abs(exact) + 1e-4);
  }
}

void expect_hessian(double far_mm) {
  const FemModel m = layered_model();
  ReferenceElasticity e(m, some_springs(m));
  // Springs on fixed nodes are left out of the Hessian (they cannot move), so only free nodes are compared.
  const auto u = test::random_displacement(m, far_mm, 3);
  const Eigen::MatrixXd H = e.dense_hessian(u, false);
  EXPECT_LT((H - H.transpose()).norm(), 1e-12 * H.norm());
  Random r(4);
  std::vector<Vec3> d(u.size(), Vec3::Zero());
  Eigen::VectorXd dv = Eigen::VectorXd::Zero(H.rows());
  for (size_t i = 0; i < d.size(); ++i)
    if (!m.fixed[i]) d[i] = r.vector(1), dv.segment<3>(Eigen::Index(3 * i)) = d[i];
  const double h = 1e-5;
  auto at = [&](double t) {
    auto v = u;
    for (size_t i = 0; i < v.size(); ++i) v[i] += t * d[i];
    std::vector<Vec3> g;
    e.gradient(v, g);
    return g;
  };
  const auto gp = at(h), gm = at(-h);
  const Eigen::VectorXd Hd = H * dv;
  double error = 0;
  for (size_t i = 0; i < d.size(); ++i)
    if (!m.fixed[i]) error = std::max(error, ((gp[i] - gm[i]) / (2 * h) - Hd.segment<3>(Eigen::Index(3 * i))).norm());
  EXPECT_LT(error, 1e-7 * Hd.norm());
}
TEST(Reference, HessianIsTheDerivativeOfTheGradient) { expect_hessian(0.4); }
TEST(Reference, HessianIsTheDerivativeOfTheGradientWhereCellsAreFlattened) { expect_hessian(2.0); }

TEST(Reference, ProjectedHessianIsSemidefiniteAndEqualWhereTheTrueOneIs) {
  BoxSpec b;
  b.cells = {2, 2, 2};
  const FemModel m = box_model(b);
  ReferenceElasticity e(m, {});
  const auto far = test::random_displacement(m, 4, 7);
  const Eigen::MatrixXd P = e.dense_hessian(far, true);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eig(P), raw(e.dense_hessian(far, false));
  EXPECT_LT(raw.eigenvalues()[0], -1e-3 * raw.eigenvalues().maxCoeff());  // the start is a bad one
  EXPECT_GT(eig.eigenvalues()[0], -1e-12 * eig.eigenvalues().maxCoeff());
  // A pure swelling: every eigenvalue of the cell is positive, so nothing may be projected away.
  std::vector<Vec3> u;
  for (const Vec3& X : m.X_mm) u.push_back(0.02 * X);
  EXPECT_LT((e.dense_hessian(u, true) - e.dense_hessian(u, false)).norm(), 1e-12 * P.norm());
}

// Homogeneous F: nodal force = V P grad N, hourglass forces vanish.
TEST(Elements, HomogeneousDeformationGivesTheStressOfTheClosedForm) {
  const Vec3 h(2, 3, 1.5);
  const Elastic el = elastic_from_young(40, 0.4);
  BoxSpec b;
  b.cells = {1, 1, 1}, b.size_mm = h, b.young_bottom_kPa = b.young_top_kPa = 40, b.poisson = 0.4;
  const FemModel m = box_model(b);
  Mat3 F;
  F << 1.1, 0.3, -0.1, 0.05, 0.9, 0.2, 0, -0.15, 1.2;
  std::vector<Vec3> u, g;
  for (const Vec3& X : m.X_mm) u.push_back((F - Mat3::Identity()) * X);
  ReferenceElasticity e(m, {});
  e.gradient(u, g);
  const Mat3 cof = F.determinant() * F.inverse().transpose();
  const Mat3 P = el.mu_kPa * F + (el.lambda_kPa * (F.determinant() - 1) - el.mu_kPa) * cof;
  for (int a = 0; a < 8; ++a) {
    Vec3 B;
    for (int i = 0; i < 3; ++i) B[i] = (((a >> i) & 1) ? 1 : -1) / (4 * h[i]);
    EXPECT_LT((g[size_t(m.cells[0].node[size_t(a)])] - h.prod() * P * B).norm(), 1e-10 * P.norm());
  }
}

TEST(Elements, RigidMotionMakesNoForce) {
  BoxSpec b;
  b.cells = {3, 3, 2};
  const FemModel m = box_model(b);
  const Mat3 R = Eigen::AngleAxisd(2.0, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
  std::vector<Vec3> u, g;
  for (const Vec3& X : m.X_mm) u.push_back((R - Mat3::Identity()) * X + Vec3(3, -8, 11));
  ReferenceElasticity e(m, {});
  e.gradient(u, g);
  const double stiff = m.stencils[0].mu_kPa * m.cell_mm[0] * m.cell_mm[0];  // force of a unit strain
  for (const Vec3& f : g) EXPECT_LT(f.norm(), 1e-12 * stiff);
  fem::ElementSystem cells(std::make_shared<FemModel>(m));
  NodeArray uf(u.size()), gf(u.size());
  for (size_t i = 0; i < u.size(); ++i) uf[i] = {float(u[i][0]), float(u[i][1]), float(u[i][2]), 0};
  cells.evaluate(uf, gf, false, test::engine());
  // u ~ 20 mm carries 2e-6 mm of rounding, on 2.5 mm cells: strain 1e-6, times ke/mu ~ 4 and a few cells per node.
  for (size_t i = 0; i < u.size(); ++i) EXPECT_LT(Vec3(gf[i].x, gf[i].y, gf[i].z).norm(), 2e-5 * stiff);
}

TEST(Elements, KernelAgreesWithTheReference) {
  for (const auto& [nu, far_mm] :
       {std::pair{0.3, 0.5}, {0.45, 0.5}, {0.45, 3.0}}) {  // 3 mm: cells inverted and flattened
    const FemModel m = layered_model(nu);
    const auto u = test::to_float(test::random_displacement(m, far_mm, 11));
    std::vector<Vec3> ud, g;
    for (const Vec3f& v : u) ud.push_back(v.cast<double>());
    ReferenceElasticity e(m, {});
    const double energy = e.gradient(ud, g);
    fem::ElementSystem cells(std::make_shared<FemModel>(m), false);
    NodeArray uf(u.size()), gf(u.size());
    for (size_t i = 0; i < u.size(); ++i) uf[i] = {u[i][0], u[i][1], u[i][2], 0};
    const fem::CellSums s = cells.evaluate(uf, gf, true, test::engine());
    EXPECT_NEAR(s.energy, energy, 1e-6 * s.magnitude);
    double size = 0, error = 0, total = 0;
    for (size_t i = 0; i < u.size(); ++i) {
      size += g[i].squaredNorm(), error += (g[i] - Vec3(gf[i].x, gf[i].y, gf[i].z)).squaredNorm();
      EXPECT_GE(double(gf[i].w), g[i].norm() * (1 - 1e-5));  // triangle inequality
      total += double(gf[i].w);
    }
    EXPECT_LT(std::sqrt(error), 1e-6 * std::sqrt(size));
    EXPECT_GT(total, 0);
  }
}

// The fixed point of the update is the primal pressure, whatever the deformation, as long as no clamp acts.
TEST(Elements, MultipliersConvergeToThePrimalForceAtAFixedDeformation) {
  const FemModel m = layered_model(0.45);
  const auto u = test::to_float(test::random_displacement(m, 0.02, 12));
  fem::ElementSystem primal(std::make_shared<FemModel>(m), false), augmented(std::make_shared<FemModel>(m), true);
  ASSERT_TRUE(augmented.has_multipliers());
  NodeArray uf(u.size()), gp(u.size()), ga(u.size());
  for (size_t i = 0; i < u.size(); ++i) uf[i] = {u[i][0], u[i][1], u[i][2], 0};
  const double energy = primal.evaluate(uf, gp, false, test::engine()).energy;
  double first = 0, last = 0, augmented_energy = 0;
  for (int k = 0; k < 200; ++k) {
    augmented_energy = augmented.evaluate(uf, ga, false, test::engine()).energy;
    last = 0;
    for (size_t i = 0; i < u.size(); ++i)
      last += Vec3(ga[i].x - gp[i].x, ga[i].y - gp[i].y, ga[i].z - gp[i].z).squaredNorm();
    if (k == 0) first = last;
    augmented.update_multipliers(test::engine());
  }
  EXPECT_LT(std::sqrt(last), 1e-4 * std::sqrt(first));
  EXPECT_NEAR(augmented_energy + augmented.energy_to_primal(), energy, 1e-4 * std::abs(energy));
}

// As if theta stayed: the pressure of the next evaluate is lambda theta, but in the cells that are left as they are.
TEST(Elements, MultipliersSettleAtOnceWhereTheyAreAskedTo) {
  const FemModel m = layered_model(0.45);
  const auto u = test::to_float(test::random_displacement(m, 0.02, 12));
  NodeArray uf(u.size()), g(u.size());
  for (size_t i = 0; i < u.size(); ++i) uf[i] = {u[i][0], u[i][1], u[i][2], 0};
  fem::ElementSystem at_once(std::make_shared<FemModel>(m)), in_the_end(std::make_shared<FemModel>(m));
  for (int k = 0; k < 200; ++k) {
    in_the_end.evaluate(uf, g, false, test::engine());
    in_the_end.update_multipliers(test::engine());
  }
  at_once.evaluate(uf, g, false, test::engine());
  const std::vector<int32_t> left{1, 5};
  AlignedArray<float> before;
  ASSERT_TRUE(at_once.settle_multipliers(before, left));
  for (size_t c = 0; c < m.cells.size(); ++c) {
    if (std::find(left.begin(), left.end(), int32_t(c)) != left.end())
      EXPECT_EQ(at_once.q(c), 0) << c;
    else
      EXPECT_NEAR(at_once.q(c), in_the_end.q(c), 1e-4 * std::fabs(in_the_end.q(c)) + 1e-7) << c;
  }
}

// A cut gives some cells other nodes and adds copies of cells: the system that takes its tiles over from the one before
// has the same numbers in it as one that is made from nothing.
TEST(ElementSystem, TilesTakenOverAreThoseMadeAnew) {
  BoxSpec b;
  b.cells = {50, 40, 3};
  b.size_mm = {100, 80, 6};
  b.young_bottom_kPa = 18;
  Random r(11);
  const auto below = [&](size_t n) { return std::min(n - 1, size_t((r.uniform() + 1) / 2 * double(n))); };
  FemModel first = box_model(b);
  for (size_t i = 0; i < first.cells.size(); ++i)
    if (i % 3 > 0) {  // as on a face
      Stencil own = first.stencils[size_t(first.cells[i].stencil)];
      own.volume_mm3 *= 1.5 + r.uniform();
      first.cells[i].stencil = int32_t(first.stencils.size()), first.stencils.push_back(own);
    }
  auto model = std::make_shared<const FemModel>(first);
  auto system = std::make_unique<fem::ElementSystem>(model);
  size_t tiles = 0, with_lanes = 0, shared = 0;
  for (int round = 0; round < 12; ++round) {
    auto next = std::make_shared<FemModel>(*model);
    const auto duplicate = [&](int32_t node) {
      next->X_mm.push_back(Vec3(next->X_mm[size_t(node)]));
      return int32_t(next->X_mm.size()) - 1;
    };
    const int changes = round == 5 ? 0 : round == 9 ? 1500 : 3;
    for (int i = 0; i < changes; ++i) {
      HexCell c = next->cells[below(next->cells.size())];
      c.node[below(8)] = duplicate(c.node[0]);
      if (i % 7 == 5) c.scale = 0;
      next->cells.push_back(c);
      HexCell& old = next->cells[below(model->cells.size())];
      const size_t corner = below(8);
      if (corner) old.node[corner] = duplicate(old.node[corner]);
      if (round == 7) old.scale = 0.5f;
      if (round == 10) old.scale = 0;  // it leaves its tile: all is made anew
    }
    if (round > 3) next->stencils.push_back(Stencil(next->stencils[5]));
    auto taken_over = std::make_unique<fem::ElementSystem>(next, true, model.get(), system.get());
    const fem::ElementSystem anew(next);
    const fem::KernelData &x = taken_over->kernel(), &y = anew.kernel();
    ASSERT_EQ(x.tiles.size(), y.tiles.size()) << round;
    for (size_t t = 0; t < x.tiles.size(); ++t) {
      EXPECT_EQ(x.tiles[t].first_cell, y.tiles[t].first_cell);
      EXPECT_EQ(x.tiles[t].last_cell, y.tiles[t].last_cell);
      EXPECT_EQ(x.tiles[t].first_slot, y.tiles[t].first_slot);
      EXPECT_EQ(x.tiles[t].last_slot, y.tiles[t].last_slot);
    }
    for (size_t t = 0; t < x.tiles.size(); ++t) {
      ASSERT_EQ(x.lanes[t] == nullptr, y.lanes[t] == nullptr) << round;
      if (!x.lanes[t]) continue;
      if (const auto& old = system->kernel().lanes; std::find(old.begin(), old.end(), x.lanes[t]) != old.end())
        ++shared;
      with_lanes += 1;
      EXPECT_EQ(x.lanes[t]->kind, y.lanes[t]->kind);
      ASSERT_EQ(x.lanes[t]->block.size(), y.lanes[t]->block.size());
      EXPECT_EQ(std::memcmp(x.lanes[t]->block.data(), y.lanes[t]->block.data(),
                            x.lanes[t]->block.size() * sizeof(fem::LaneBlock)),
                0);
    }
    EXPECT_EQ(x.slot_node, y.slot_node) << round;
    EXPECT_EQ(x.node_slots, y.node_slots) << round;
    EXPECT_EQ(x.node_slots_begin, y.node_slots_begin) << round;
    ASSERT_EQ(x.cells.size(), y.cells.size());
    for (size_t c = 0; c < x.cells.size(); ++c)
      EXPECT_TRUE(std::equal(std::begin(x.cells[c].node), std::end(x.cells[c].node), std::begin(y.cells[c].node)) &&
                  x.cells[c].stencil == y.cells[c].stencil && x.cells[c].scale == y.cells[c].scale)
          << round << ": cell " << c;
    model = next;
    system = std::move(taken_over);
    tiles += x.tiles.size();
  }
  EXPECT_GT(shared, 20u);
  EXPECT_GT(with_lanes, shared);
  EXPECT_GT(tiles, 80u);  // several to take over in each round
}

}  // namespace test_elements
}  // namespace limberg
