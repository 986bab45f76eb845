// Cells that are no boxes: patch tests, derivatives, and the one minimiser on all of them.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "sim/base/error.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/materials/stable_neo_hookean.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "sim/testing/reference_newton.h"
#include "sim/testing/tet_lattice.h"
#include "tests/sim/fem/models.h"

namespace limberg {
namespace test_shaped_cells {

using test::Random;

/// A 3 x 3 x 3 block of hexahedra with its inner nodes moved about; sides fixed.
FemModel crooked_hexes(bool full, double poisson = 0.4) {
  const Elastic e = elastic_from_young(60, poisson);
  ShapedModel s;
  const int32_t shape =
      s.add_law(full ? stable_neo_hookean_full(e.mu_kPa, e.lambda_kPa, e.mu_kPa) : neo_hookean(e.mu_kPa));
  const int32_t volume = full ? -1 : s.add_law(stable_neo_hookean_full(0, e.lambda_kPa, e.mu_kPa));
  Random r(5);
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) {
        const bool outer = i % 3 == 0 || j % 3 == 0 || k % 3 == 0;
        s.add_node(3 * Vec3(i, j, k) + (outer ? Vec3::Zero() : r.vector(0.8)), outer);
      }
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        std::array<int32_t, 8> n;
        for (int a = 0; a < 8; ++a) n[size_t(a)] = ((k + (a >> 2)) * 4 + j + (a >> 1 & 1)) * 4 + i + (a & 1);
        s.add_hex(n, shape, volume);
      }
  return s.finish();
}

FemModel crooked_tets(double poisson = 0.4) {
  BoxSpec b;
  b.cells = {2, 2, 2}, b.size_mm = {6, 6, 6}, b.poisson = poisson;
  FemModel straight = bcc_box_model(b);
  Random r(9);
  std::vector<Vec3> X = straight.X_mm.flat();
  std::vector<Held> outer(X.size());
  for (size_t i = 0; i < X.size(); ++i) {
    outer[i] = std::abs(std::abs(X[i][0]) - 3) < 1e-9 || std::abs(std::abs(X[i][1]) - 3) < 1e-9 ||
               std::abs(X[i][2] - 3) > 3 - 1e-9;
    if (!outer[i]) X[i] += r.vector(0.4);
  }
  std::vector<std::array<int32_t, 4>> t;
  for (const HexCell& c : straight.cells) t.push_back({c.node[0], c.node[1], c.node[2], c.node[3]});
  FemModel m = tet_mesh_model(X, t, 60, poisson);
  m.fixed = outer;
  return m;
}

double largest(const std::vector<Vec3>& g, const FemModel& m, bool free_only) {
  double most = 0;
  for (size_t i = 0; i < g.size(); ++i)
    if (!free_only || !m.fixed[i]) most = std::max(most, g[i].norm());
  return most;
}

// Any even deformation leaves every inner node at rest, and inner nodes find their places from the boundary alone.
TEST(ShapedCells, PatchTest) {
  Mat3 A;
  A << 1.2, 0.3, -0.1, 0.05, 0.9, 0.2, -0.2, 0.1, 1.1;
  for (const FemModel& m : {crooked_hexes(false), crooked_hexes(true), crooked_tets()}) {
    const ReferenceElasticity e(m, {});
    std::vector<Vec3> u, start, g;
    Random r(3);
    for (size_t i = 0; i < m.X_mm.size(); ++i) {
      u.push_back((A - Mat3::Identity()) * m.X_mm[i]);
      start.push_back(m.fixed[i] ? u.back() : Vec3(u.back() + r.vector(0.3)));
    }
    e.gradient(u, g);
    EXPECT_LT(largest(g, m, true), 1e-10 * largest(g, m, false));
    const auto found = e.solve(start, {});
    double error = 0;
    for (size_t i = 0; i < u.size(); ++i) error = std::max(error, (found.u[i] - u[i]).norm());
    EXPECT_LT(error, 1e-9);
  }
}

TEST(ShapedCells, RestAndRotationMakeNoForce) {
  for (const FemModel& m : {crooked_hexes(false), crooked_hexes(true), crooked_tets()})
    for (double angle : {0.0, M_PI / 2, M_PI}) {
      const Mat3 R = Eigen::AngleAxisd(angle, Vec3(1, 2, 3).normalized()).toRotationMatrix();
      std::vector<Vec3> u, g;
      for (const Vec3& X : m.X_mm) u.push_back(R * X - X);
      ReferenceElasticity(m, {}).gradient(u, g);
      EXPECT_LT(largest(g, m, false), 1e-10 * 20 * 9);  // mu times the square of a cell
    }
}

TEST(ShapedCells, GradientAndHessianAreDerivatives) {
  for (const FemModel& m : {crooked_hexes(false), crooked_hexes(true), crooked_tets()}) {
    const ReferenceElasticity e(m, {});
    const auto u = test::random_displacement(m, 0.4, 1);
    std::vector<Vec3> g, g1, g0;
    e.gradient(u, g);
    const Eigen::MatrixXd H = e.dense_hessian(u, false);
    EXPECT_LT((H - H.transpose()).norm(), 1e-12 * H.norm());
    Random r(2);
    std::vector<Vec3> p = u, q = u;
    Eigen::VectorXd d(3 * Eigen::Index(u.size()));
    double exact = 0;
    const double h = 1e-5;
    for (size_t i = 0; i < u.size(); ++i) {
      const Vec3 v = r.vector(1);
      exact += g[i].dot(v), p[i] += h * v, q[i] -= h * v;
      d.segment<3>(3 * Eigen::Index(i)) = v;
    }
    EXPECT_NEAR((e.gradient(p, g1) - e.gradient(q, g0)) / (2 * h), exact, 1e-7 * (std::fabs(exact) + 1000));
    const Eigen::VectorXd Hd = H * d;
    double error = 0;
    for (size_t i = 0; i < u.size(); ++i)
      error = std::max(error, ((g1[i] - g0[i]) / (2 * h) - Hd.segment<3>(3 * Eigen::Index(i))).norm());
    EXPECT_LT(error, 1e-6 * Hd.norm());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eig(e.dense_hessian(u, true), Eigen::EigenvaluesOnly);
    EXPECT_GT(eig.eigenvalues()[0], -1e-9 * eig.eigenvalues().tail<1>()[0]);
  }
}

// A hexahedron that happens to be a box is the lattice's own cell.
TEST(ShapedCells, ABoxIsTheLatticesCell) {
  BoxSpec b;
  b.cells = {3, 2, 2}, b.size_mm = {6, 5, 4};
  const FemModel lattice = box_model(b);
  const Elastic e = elastic_from_young(b.young_top_kPa, b.poisson);
  ShapedModel s;
  const int32_t shape = s.add_law(neo_hookean(e.mu_kPa)),
                volume = s.add_law(stable_neo_hookean_full(0, e.lambda_kPa, e.mu_kPa));
  for (const Vec3& X : lattice.X_mm) s.add_node(X);
  for (const HexCell& c : lattice.cells) s.add_hex(c.node, shape, volume);
  const FemModel shaped = s.finish();
  const auto u = test::random_displacement(lattice, 0.5, 4);
  std::vector<Vec3> ga, gb;
  const double ea = ReferenceElasticity(lattice, {}).gradient(u, ga),
               eb = ReferenceElasticity(shaped, {}).gradient(u, gb);
  EXPECT_NEAR(ea, eb, 1e-10 * ea);
  for (size_t i = 0; i < ga.size(); ++i) EXPECT_LT((ga[i] - gb[i]).norm(), 1e-10 * largest(ga, lattice, false));
}

// The program's own minimiser, in single precision, on tetrahedra.
TEST(ShapedCells, TheMinimiserFindsNewtonsAnswerOnTetrahedra) {
  BoxSpec b;
  b.cells = {5, 4, 3}, b.size_mm = {15, 12, 9}, b.fix_bottom = true;
  const auto m = std::make_shared<FemModel>(bcc_box_model(b));
  Spring hook;
  hook.id = 1, hook.to_world = true, hook.a = embed_in_tets(*m, {1, 1, 9}), hook.target_mm = {3, 2, 14},
  hook.k_N_per_mm = 0.3;
  const auto exact =
      ReferenceElasticity(*m, std::span(&hook, 1)).solve(std::vector<Vec3>(m->X_mm.size(), Vec3::Zero()), {});
  ASSERT_TRUE(exact.converged);
  InlineWorkers workers;
  fem::LbfgsSolver solver(workers, true, {1 << 30});
  solver.set_model(m, {});
  solver.set_springs(std::span(&hook, 1));
  StepSettings s;
  s.max_iterations = 400, s.tolerance = 1e-6;
  const StepReport r = solver.step(s);
  double error = 0;
  for (size_t i = 0; i < exact.u.size(); ++i)
    error = std::max(error, (solver.displacement_mm()[i].cast<double>() - exact.u[i]).norm());
  EXPECT_LT(error, 2e-3);
  EXPECT_FALSE(r.metric_is_cycle);
  EXPECT_EQ(0, r.inverted_cells);
}

TEST(ShapedCells, VolumesAddUp) {
  for (int n : {1, 2, 3}) {
    BoxSpec b;
    b.cells = {n, n, n}, b.size_mm = {5, 7, 9};
    const FemModel m = bcc_box_model(b);
    double V = 0, mass = 0;
    for (const Stencil& s : m.stencils) V += s.volume_mm3;
    for (double v : m.mass_kg) mass += v;
    EXPECT_NEAR(V, 5 * 7 * 9, 1e-9);
    EXPECT_NEAR(mass, 1e-6 * V, 1e-15);
  }
}

TEST(ShapedCells, BadMeshesAreRefused) {
  const std::vector<Vec3> X = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  const std::array<std::array<int32_t, 4>, 1> flat = {{{0, 1, 2, 3}}}, beyond = {{{0, 1, 2, 4}}};
  EXPECT_THROW(tet_mesh_model(X, flat, 60, 0.45), InputError);
  EXPECT_THROW(tet_mesh_model(X, beyond, 60, 0.45), InputError);
  ShapedModel s;
  const int32_t law = s.add_law(neo_hookean(1));
  for (int a = 0; a < 8; ++a) s.add_node(Vec3(a & 1, a >> 1 & 1, a >> 2));
  EXPECT_THROW(s.add_hex({1, 0, 2, 3, 4, 5, 6, 7}, law), InputError);
  EXPECT_THROW(stable_neo_hookean_full(-1, 1, 1), InputError);
}

}  // namespace test_shaped_cells
}  // namespace limberg
