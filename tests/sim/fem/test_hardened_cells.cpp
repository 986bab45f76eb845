// Cells whose laws have hardened, as the metric is to see them.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "sim/fem/elements/effective_bulk.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/materials/limited.h"
#include "sim/fem/preconditioner/hardened_cells.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "sim/testing/reference_newton.h"
#include "tests/sim/fem/models.h"

namespace limberg {
namespace test_hardened_cells {

LawPtr fibrous() { return sum_of({neo_hookean(10), dispersed_fibres({100, 1, 0.1}, {{{1, 0, 0}}})}); }

/// A cube of n cells of 2 mm a side of one law whose base is held; nu .45 where the law is neo-Hookean.
FemModel cube(int n, const LawPtr& law) {
  BoxSpec b;
  b.cells = {n, n, n}, b.size_mm = Vec3::Constant(2.0 * n);
  b.fix_bottom = true;
  FemModel m = box_model(b);
  m.laws = {law};
  for (Stencil& s : m.stencils) s = fem::law_stencil(m.cell_mm, 0, *law, 110);
  return m;
}

const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
Mat3 drawn(double along_x) { return turn * Vec3(along_x, 1 / std::sqrt(along_x), 1 / std::sqrt(along_x)).asDiagonal(); }

/// Of the first cell: its tangent at the displacement that F makes, traced over x, y and z; volume apart.
Mat8 traced_tangent(const FemModel& m, const Mat3& F) {
  const Stencil& s = m.stencils[size_t(m.cells[0].stencil)];
  Eigen::Matrix<double, 8, 3> u;
  for (int a = 0; a < 8; ++a)
    u.row(a) = ((F - Mat3::Identity()) * m.X_mm[size_t(m.cells[0].node[size_t(a)])]).transpose();
  const auto H = fem::points_tangent(m, s, m.cell_mm, u, true);
  Mat8 traced;
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < 8; ++b) traced(a, b) = H.block<3, 3>(3 * a, 3 * b).trace() / 3;
  return traced;
}

/// Of the first cell, as the metric has it; volume apart.
Mat8 seen_matrix(const FemModel& m, const fem::HardenedCells& hard) {
  const auto seen = hard.seen(std::make_shared<FemModel>(m), true);
  const Stencil& s = seen->stencils[size_t(seen->cells[0].stencil)];
  const auto B = volume_gradients(s, m.cell_mm);
  return fem::scalar_cell_matrix(*seen, s, true) -
         fem::effective_bulk_kPa(s, true) * s.volume_mm3 * (B * B.transpose());
}

TEST(HardenedCells, AreSeenAsStiffAsTheirTangent) {
  const FemModel m = cube(2, fibrous());
  const Mat3 F = drawn(1.5);
  fem::HardenedCells hard;
  ASSERT_TRUE(hard.follow(m, test::moved_by(m, F), test::engine()));
  const Mat8 now = traced_tangent(m, F), rest = traced_tangent(m, Mat3::Identity()), seen = seen_matrix(m, hard);
  EXPECT_GT(now.norm(), 10 * rest.norm()) << "nothing has hardened";
  EXPECT_LT((seen - now).norm(), 1e-5 * now.norm());
}

TEST(HardenedCells, NothingAtRestNorTurnedNorForFewNorForALittle) {
  const FemModel m = cube(2, fibrous());
  fem::HardenedCells hard;
  EXPECT_FALSE(hard.follow(m, test::moved_by(m, Mat3::Identity()), test::engine()));
  EXPECT_FALSE(hard.follow(m, test::moved_by(m, turn), test::engine()));
  EXPECT_FALSE(hard.follow(m, test::moved_by(m, drawn(0.7)), test::engine())) << "fibres that are slack";
  EXPECT_TRUE(hard.empty());
  const auto model = std::make_shared<FemModel>(m);
  EXPECT_EQ(hard.seen(model, false), model);
  const FemModel one = cube(1, fibrous());
  EXPECT_FALSE(hard.follow(one, test::moved_by(one, drawn(1.5)), test::engine()));

  ASSERT_TRUE(hard.follow(m, test::moved_by(m, drawn(1.5)), test::engine()));
  EXPECT_FALSE(hard.empty());
  EXPECT_FALSE(hard.follow(m, test::moved_by(m, drawn(1.52)), test::engine())) << "near enough";
  EXPECT_TRUE(hard.follow(m, test::moved_by(m, drawn(1.9)), test::engine()));
  EXPECT_TRUE(hard.follow(m, test::moved_by(m, Mat3::Identity()), test::engine())) << "slack again";
  EXPECT_TRUE(hard.empty());
}

TEST(HardenedCells, LimitsOfStretchAreSeenBeyondThemOnly) {
  const LawPtr law = sum_of({neo_hookean(10), stretch_limits(0.8, 1.2, 1000)});
  const FemModel m = cube(2, law);
  fem::HardenedCells hard;
  EXPECT_FALSE(hard.follow(m, test::moved_by(m, drawn(1.15)), test::engine()));
  ASSERT_TRUE(hard.follow(m, test::moved_by(m, drawn(1.3)), test::engine()));
  const Mat8 now = traced_tangent(m, drawn(1.3));
  EXPECT_LT((seen_matrix(m, hard) - now).norm(), 1e-5 * now.norm());
}

TEST(HardenedCells, GoOverToWhatACutMakesOfThem) {
  const FemModel m = cube(2, fibrous());
  fem::HardenedCells hard;
  ASSERT_TRUE(hard.follow(m, test::moved_by(m, drawn(1.5)), test::engine()));
  const Mat8 before = seen_matrix(m, hard);
  FemModel more = m;
  std::vector<int32_t> parent{3, -1, 0, 1, 2, 3, 4, 5, 6, 7};
  more.cells.push_back(m.cells[0]), more.cells.push_back(m.cells[1]);
  hard.carry(parent, more.cells.size());
  EXPECT_LT((seen_matrix(more, hard) - before).norm(), 1e-6 * before.norm());
  const auto seen = hard.seen(std::make_shared<FemModel>(more), false);
  EXPECT_TRUE(seen->stencils[size_t(seen->cells[0].stencil)].points.empty());
  EXPECT_FALSE(seen->stencils[size_t(seen->cells[1].stencil)].points.empty()) << "it has no parent";
  EXPECT_EQ(seen->parent, more.parent);
  hard.carry({}, 4);
  EXPECT_TRUE(hard.empty()) << "another body";
}

/// The spread of the eigenvalues of M^-1 H over the free nodes at the displacement that F makes: what a step's
/// iterations depend on. H: tangent of the points and of the volume; M: the scalar matrix, for x, y and z alike.
double spread(const FemModel& m, const FemModel& metric, const Mat3& F) {
  std::vector<int32_t> row(m.X_mm.size(), -1);
  int n = 0;
  for (size_t i = 0; i < row.size(); ++i)
    if (!m.fixed[i].all()) row[i] = n++;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3 * n, 3 * n), M = H;
  for (size_t c = 0; c < m.cells.size(); ++c) {
    const HexCell& cell = m.cells[c];
    const Stencil &s = m.stencils[size_t(cell.stencil)], &t = metric.stencils[size_t(metric.cells[c].stencil)];
    Eigen::Matrix<double, 8, 3> u;
    for (int a = 0; a < 8; ++a) u.row(a) = ((F - Mat3::Identity()) * m.X_mm[size_t(cell.node[size_t(a)])]).transpose();
    Eigen::Matrix<double, 24, 24> h = fem::points_tangent(m, s, m.cell_mm, u, true);
    Mat3 cof;
    for (int i = 0; i < 3; ++i) cof.col(i) = F.col((i + 1) % 3).cross(F.col((i + 2) % 3));
    const Eigen::Matrix<double, 3, 8> slope = cof * volume_gradients(s, m.cell_mm).transpose();
    const Eigen::Map<const Eigen::Matrix<double, 24, 1>> J(slope.data());
    h += fem::effective_bulk_kPa(s, true) * s.volume_mm3 * J * J.transpose();
    const Mat8 k = fem::scalar_cell_matrix(metric, t, true);
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) {
        const int i = row[size_t(cell.node[size_t(a)])], j = row[size_t(cell.node[size_t(b)])];
        if (i < 0 || j < 0) continue;
        H.block<3, 3>(3 * i, 3 * j) += h.block<3, 3>(3 * a, 3 * b);
        M.block<3, 3>(3 * i, 3 * j) += k(a, b) * Mat3::Identity();
      }
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> e(H, M, Eigen::EigenvaluesOnly);
  return e.eigenvalues()[3 * n - 1] / e.eigenvalues()[0];
}

TEST(HardenedCells, TheSpectrumIsNarrowAgain) {
  const FemModel m = cube(4, fibrous());
  const auto model = std::make_shared<FemModel>(m);
  const double at_rest = spread(m, m, Mat3::Identity());
  for (const double stretch : {1.3, 1.5, 1.7}) {
    fem::HardenedCells hard;
    ASSERT_TRUE(hard.follow(m, test::moved_by(m, drawn(stretch)), test::engine()));
    const double without = spread(m, m, drawn(stretch)), with = spread(m, *hard.seen(model, true), drawn(stretch));
    // 2026-11-29: at rest 58; without 48, 87, 153; with 17, 15, 23.
    EXPECT_LT(with, at_rest / 2) << stretch;
    EXPECT_GT(without, 2.5 * with) << stretch;
  }
}

/// Two sides are drawn to that stretch by springs; iterations to rest.
int iterations(const LawPtr& law, double stretch, bool undone, std::vector<Vec3f>* end = nullptr) {
  const FemModel m = cube(5, law);
  InlineWorkers w;
  fem::LbfgsSolver solver(w);
  solver.set_model(std::make_shared<FemModel>(m), {});
  std::vector<Spring> springs;
  for (size_t i = 0; i < m.X_mm.size(); ++i) {
    if (std::fabs(m.X_mm[i][0]) < 5 - 1e-6) continue;
    Spring& p = springs.emplace_back();
    p.id = int32_t(i) + 1, p.to_world = true, p.a = embed(m, m.X_mm[i]), p.k_N_per_mm = 5;
    p.target_mm = Vec3(stretch * m.X_mm[i][0], m.X_mm[i][1], m.X_mm[i][2]);
  }
  solver.set_springs(springs);
  StepSettings s;
  s.max_iterations = 10, s.tolerance = 1e-5;
  int n = 0;
  for (int k = 0; k < 200; ++k) {
    if (undone && k == 3) {  // gone on for some steps, and back: the same as if nothing had been
      const SolverState state = solver.save();
      const auto path = solver.path();
      for (int extra = 0; extra < 6; ++extra) solver.step(s);
      solver.set_model(std::make_shared<FemModel>(m), test::identity_parents(m));
      solver.set_springs(springs);
      solver.take_up(*path);
      solver.restore(state);
    }
    if (!undone && k == 3) {
      const SolverState state = solver.save();
      solver.restore(state);
    }
    const StepReport r = solver.step(s);
    n += r.iterations;
    if (r.converged) break;
  }
  if (end) end->assign(solver.displacement_mm().begin(), solver.displacement_mm().end());
  return n;
}

TEST(HardenedCells, AnUndoneStepLeavesNoTrace) {
  std::vector<Vec3f> straight, undone;
  const int a = iterations(fibrous(), 1.5, false, &straight), b = iterations(fibrous(), 1.5, true, &undone);
  EXPECT_EQ(a, b);
  for (size_t i = 0; i < straight.size(); ++i) ASSERT_EQ(straight[i], undone[i]) << i;
}

// 2026-11-29: 25 and 60; 41 and 88 with the metric as it is at rest. The bars lie half way.
TEST(HardenedCells, DrawnFibresAndLimitsRestInFewerIterations) {
  const LawPtr limited = sum_of({neo_hookean(10), stretch_limits(0.8, 1.2, 2000)});
  EXPECT_LT(iterations(fibrous(), 1.5, false), 33);
  EXPECT_LT(iterations(limited, 1.5, false), 74);
}

}  // namespace test_hardened_cells
}  // namespace limberg
