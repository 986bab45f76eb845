// Cells of several levels and the nodes that hang between them.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "divided_box.h"
#include "models.h"
#include "sim/fem/model/hanging_nodes.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "sim/testing/reference_newton.h"

namespace limberg {
namespace test_hanging {

using test::divide;
using test::DividedModel;
using test::Random;

FemModel box(Int3 cells = {6, 6, 6}, bool held = false) {
  BoxSpec b;
  b.cells = cells, b.size_mm = {2.0 * cells.x, 2.2 * cells.y, 1.8 * cells.z}, b.fix_sides = held;
  return box_model(b);
}

DividedModel divided(const FemModel& m, double inner = 1) {
  const Vec3 centre(0, 0, m.cell_mm.z() * 3);
  return divide(m, test::levels_around(m, centre, inner));
}

Eigen::MatrixXd dense(const fem::ScalarMatrix& A) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(A.n(), A.n());
  for (int32_t j = 0; j < A.n(); ++j)
    for (int32_t e = A.begin[size_t(j)]; e < A.begin[size_t(j) + 1]; ++e)
      D(A.row[size_t(e)], j) = D(j, A.row[size_t(e)]) = A.value[size_t(e)];
  return D;
}

std::vector<Vec3> affine(const FemModel& m, const Mat3& G) {
  std::vector<Vec3> u;
  for (const Vec3& X : m.X_mm) u.push_back(G * X + Vec3(0.3, -0.2, 0.1));
  return u;
}

Mat3 some_gradient() {
  Mat3 G;
  G << 0.12, 0.05, -0.03, -0.04, -0.06, 0.08, 0.02, 0.07, 0.03;
  return G;
}

std::vector<Vec3> gathered(const FemModel& m, std::vector<Vec3> g) {
  for (const HangingNode& h : m.hanging) {
    for (size_t k = 0; k < size_t(h.count); ++k) g[size_t(h.master[k])] += double(h.weight[k]) * g[size_t(h.node)];
    g[size_t(h.node)].setZero();
  }
  return g;
}

std::vector<Vec3> following(const FemModel& m, std::vector<Vec3> u) {
  for (const HangingNode& h : m.hanging) {
    Vec3 s = Vec3::Zero();
    for (size_t k = 0; k < size_t(h.count); ++k) s += double(h.weight[k]) * u[size_t(h.master[k])];
    u[size_t(h.node)] = s;
  }
  return u;
}

bool on_border(const FemModel& m, const Vec3& X) {
  Vec3 lo = m.X_mm[0], hi = lo;
  for (const Vec3& x : m.X_mm) lo = lo.cwiseMin(x), hi = hi.cwiseMax(x);
  return (X - lo).minCoeff() < 1e-9 || (hi - X).minCoeff() < 1e-9;
}

TEST(Hanging, TheListIsChecked) {
  const DividedModel d = divided(box());
  EXPECT_GT(d.model.hanging.size(), 50u);
  EXPECT_EQ(fem::check_hanging(d.model), "");
  FemModel bad = d.model;
  bad.hanging[3].master[0] = bad.hanging[4].node;
  EXPECT_NE(fem::check_hanging(bad), "");
  bad = d.model;
  bad.hanging[0].weight[0] += 0.01f;
  EXPECT_NE(fem::check_hanging(bad), "");
  bad = d.model;
  std::swap(bad.hanging[0], bad.hanging[1]);
  EXPECT_NE(fem::check_hanging(bad), "");
  InlineWorkers w;
  EXPECT_ANY_THROW(make_solver(w)->set_model(std::make_shared<FemModel>(bad), {}));
}

// The patch test: a homogeneous deformation has the same energy on every lattice and no force on any inner unknown.
TEST(Hanging, AHomogeneousDeformationIsExact) {
  const FemModel whole = box();
  const DividedModel d = divided(whole);
  const Mat3 G = some_gradient();
  const auto u = affine(d.model, G);
  for (const HangingNode& h : d.model.hanging)
    EXPECT_LT((following(d.model, u)[size_t(h.node)] - u[size_t(h.node)]).norm(), 1e-12);
  ReferenceElasticity fine(d.model, {}), coarse(whole, {});
  const FemModel uniform = divide(whole, std::vector<int>(whole.cells.size(), 2)).model;
  EXPECT_TRUE(uniform.hanging.empty());
  ReferenceElasticity finest(uniform, {});
  const double e = coarse.energy(affine(whole, G));
  EXPECT_NEAR(fine.energy(u), e, 1e-11 * std::abs(e));
  EXPECT_NEAR(finest.energy(affine(uniform, G)), e, 1e-11 * std::abs(e));
  std::vector<Vec3> g;
  fine.gradient(u, g);
  double largest = 0;
  for (const Vec3& f : g) largest = std::max(largest, f.norm());
  g = gathered(d.model, g);
  int inner = 0;
  for (size_t i = 0; i < g.size(); ++i)
    if (!on_border(d.model, d.model.X_mm[i])) {
      EXPECT_LT(g[i].norm(), 1e-11 * largest);
      ++inner;
    }
  EXPECT_GT(inner, 300);
}

TEST(Hanging, GatheredForceIsTheDerivativeOverTheUnknowns) {
  const DividedModel d = divided(box());
  ReferenceElasticity e(d.model, {});
  Random r(3);
  auto u = following(d.model, test::random_displacement(d.model, 0.2, 4));
  std::vector<Vec3> g;
  e.gradient(u, g);
  g = gathered(d.model, g);
  for (int k = 0; k < 5; ++k) {
    auto v = following(d.model, test::random_displacement(d.model, 1, uint64_t(10 + k)));
    double slope = 0;
    for (size_t i = 0; i < g.size(); ++i) slope += g[i].dot(v[i]);
    const double h = 1e-5;
    auto a = u, b = u;
    for (size_t i = 0; i < u.size(); ++i) a[i] -= h * v[i], b[i] += h * v[i];
    EXPECT_NEAR((e.energy(b) - e.energy(a)) / (2 * h), slope, 1e-6 * std::abs(slope) + 1e-4);
  }
}

TEST(Hanging, KernelAgreesWithTheReference) {
  const DividedModel d = divided(box());
  const auto model = std::make_shared<FemModel>(d.model);
  fem::ElementSystem system(model, false);
  ReferenceElasticity e(d.model, {});
  const auto u = test::random_displacement(d.model, 0.2, 8);
  NodeArray uf(u.size()), g(u.size());
  std::vector<Vec3> ud;
  for (size_t i = 0; i < u.size(); ++i) {
    uf[i] = {float(u[i][0]), float(u[i][1]), float(u[i][2]), 0};
    ud.push_back({double(uf[i].x), double(uf[i].y), double(uf[i].z)});
  }
  system.evaluate(uf, g, true, test::engine());
  std::vector<Vec3> exact;
  e.gradient(ud, exact);
  for (size_t i = 0; i < u.size(); ++i)
    EXPECT_LT((Vec3(double(g[i].x), double(g[i].y), double(g[i].z)) - exact[i]).norm(), 1e-5 * (1 + double(g[i].w)));
}

// Symmetric, positive, and exactly P^T A P of the matrix that knows nothing of hanging.
TEST(Hanging, TheScalarMatrixIsProjected) {
  FemModel whole = box({4, 4, 4});
  const DividedModel d = divide(whole, test::levels_around(whole, {1, 1, 3}, 0.6));
  ASSERT_FALSE(d.model.hanging.empty());
  Spring s;
  s.id = 1, s.k_N_per_mm = 0.05, s.to_world = true;
  for (const HexCell& c : d.model.cells)
    if (c.node[0] == d.model.hanging[2].node) s.a.node = c.node;
  s.a.w = {0.3f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f};
  const std::vector<fem::SpringRow> rows{fem::spring_row(d.model, s)};
  const double mass = 3e4;
  const fem::ScalarMatrix A = fem::assemble_scalar(d.model, rows, mass);
  FemModel free = d.model;
  free.hanging.clear();
  const std::vector<fem::SpringRow> free_rows{fem::spring_row(free, s)};
  const fem::ScalarMatrix B = fem::assemble_scalar(free, free_rows, mass);
  ASSERT_EQ(size_t(B.n()), free.X_mm.size());
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(B.n(), A.n());
  const auto hangs = fem::hanging_index(d.model);
  for (int32_t v = 0; v < B.n(); ++v) {
    if (hangs[size_t(v)] < 0) {
      P(v, A.row_of_node[size_t(v)]) = 1;
      continue;
    }
    EXPECT_EQ(A.row_of_node[size_t(v)], -1);
    const HangingNode& h = d.model.hanging[size_t(hangs[size_t(v)])];
    for (size_t k = 0; k < size_t(h.count); ++k) P(v, A.row_of_node[size_t(h.master[k])]) += double(h.weight[k]);
  }
  const Eigen::MatrixXd expected = P.transpose() * dense(B) * P, D = dense(A);
  EXPECT_LT((expected - D).cwiseAbs().maxCoeff(), 3e-5 * D.diagonal().maxCoeff());  // the shift of a loose piece: 1e-5
  EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(D).info(), Eigen::Success);
}

struct Pull {
  std::vector<Spring> springs;
  explicit Pull(const FemModel& m, double k = 0.2) {
    Spring s;
    s.id = 1, s.a = embed(m, {0.4, 0.3, 8}), s.to_world = true, s.k_N_per_mm = k, s.target_mm = {2, 1, 11};
    springs.push_back(s);
  }
};

// The float solver finds the minimum over the unknowns that the
// reference Newton finds; hanging nodes lie where they must.
TEST(Hanging, TheSolverFindsTheConstrainedMinimum) {
  const FemModel whole = box({6, 6, 6}, true);
  const DividedModel d = divided(whole);
  const Pull pull(whole);
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(d.model), {});
  solver->set_springs(pull.springs);
  StepSettings settings;
  settings.max_iterations = 400, settings.tolerance = 2e-6;
  const StepReport report = solver->step(settings);
  EXPECT_TRUE(report.converged) << report.residual;
  EXPECT_LT(report.iterations, 120);
  ReferenceElasticity reference(d.model, pull.springs);
  const auto exact = reference.solve(std::vector<Vec3>(d.model.X_mm.size(), Vec3::Zero()), {});
  EXPECT_TRUE(exact.converged);
  double size = 0, error = 0;
  const auto u = solver->displacement_mm();
  for (size_t i = 0; i < u.size(); ++i)
    size = std::max(size, exact.u[i].norm()), error = std::max(error, (u[i].cast<double>() - exact.u[i]).norm());
  EXPECT_GT(size, 0.5);
  EXPECT_LT(error, 2e-3 * size);
  for (const HangingNode& h : d.model.hanging) {
    Vec3f s = Vec3f::Zero();
    for (size_t k = 0; k < size_t(h.count); ++k) s += h.weight[k] * u[size_t(h.master[k])];
    EXPECT_LT((s - u[size_t(h.node)]).norm(), 1e-6f);
  }
}

TEST(Hanging, SameBitsForAnyNumberOfWorkers) {
  const FemModel whole = box({6, 6, 6}, true);
  const DividedModel d = divided(whole);
  const Pull pull(whole);
  auto run = [&](Workers& w) {
    auto solver = make_solver(w);
    solver->set_model(std::make_shared<FemModel>(d.model), {});
    solver->set_springs(pull.springs);
    for (int i = 0; i < 5; ++i) solver->step({});
    return std::vector<Vec3f>(solver->displacement_mm().begin(), solver->displacement_mm().end());
  };
  InlineWorkers one;
  test::ThreadWorkers three(3);
  EXPECT_EQ(run(one), run(three));
}

// A mirror image of the model and of the load gives the mirror image of the answer.
TEST(Hanging, Mirror) {
  const FemModel whole = box({7, 7, 5}, true);
  const DividedModel d = divide(whole, test::levels_around(whole, {0, 0, 4.5}, 0.5));
  std::vector<Spring> springs;
  for (int side = 0; side < 2; ++side) {
    Spring s;
    s.id = side + 1, s.a = embed(whole, {side ? 2.5 : -2.5, 0.7, 9}), s.to_world = true, s.k_N_per_mm = 0.1;
    s.target_mm = {side ? 4.0 : -4.0, 1, 11};
    springs.push_back(s);
  }
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(d.model), {});
  solver->set_springs(springs);
  StepSettings settings;
  settings.max_iterations = 300, settings.tolerance = 3e-6;
  solver->step(settings);
  std::map<std::array<long, 3>, size_t> at;
  auto key = [](const Vec3& X) {
    return std::array<long, 3>{std::lround(X[0] * 1e5), std::lround(X[1] * 1e5), std::lround(X[2] * 1e5)};
  };
  for (size_t i = 0; i < d.model.X_mm.size(); ++i) at[key(d.model.X_mm[i])] = i;
  const auto u = solver->displacement_mm();
  float size = 0, error = 0;
  for (size_t i = 0; i < u.size(); ++i) {
    const Vec3 X = d.model.X_mm[i];
    const auto it = at.find(key({-X[0], X[1], X[2]}));
    ASSERT_NE(it, at.end());
    const Vec3f v = u[it->second];
    size = std::max(size, u[i].norm());
    error = std::max(error, (Vec3f(-v[0], v[1], v[2]) - u[i]).norm());
  }
  EXPECT_LT(error, 1e-3f * size);
}

// Division under load: every point stays where it was, also when its velocity is not zero, and pressures are carried.
TEST(Hanging, NothingMovesWhenCellsAreDivided) {
  const FemModel whole = box({6, 6, 6}, true);
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(whole), {});
  const Pull pull(whole, 1);
  solver->set_springs(pull.springs);
  for (int i = 0; i < 10; ++i) solver->step({});
  Random r(5);
  std::vector<Vec3> points;
  for (int i = 0; i < 500; ++i) points.push_back(Vec3(5.9 * r.uniform(), 6.5 * r.uniform(), 5.4 + 5.3 * r.uniform()));
  std::vector<Vec3> before;
  for (const Vec3& X : points) before.push_back(solver->position_mm(embed(whole, X)));
  DividedModel d = divided(whole);
  solver->set_model(std::make_shared<FemModel>(d.model), d.cell_parent);
  double jump = 0, size = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    jump = std::max(jump, (solver->position_mm(embed(d.model, points[i])) - before[i]).norm());
    size = std::max(size, (before[i] - points[i]).norm());
  }
  EXPECT_GT(size, 1);
  EXPECT_LT(jump, 1e-6);
}

}  // namespace test_hanging
}  // namespace limberg
