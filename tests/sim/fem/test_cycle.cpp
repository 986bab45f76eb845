// The multilevel metric: a symmetric positive definite operator close to the inverse, at any size and through any cut,
// and the same to the bit whether it was made afresh or carried over.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "cut_models.h"
#include "divided_box.h"
#include "sim/fem/solver/cycle.h"

namespace limberg {
namespace test_cycle {

using fem::ScalarCycle;
using test::Random;

Eigen::MatrixXd dense(const fem::ScalarMatrix& A) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(A.n(), A.n());
  for (int32_t j = 0; j < A.n(); ++j)
    for (int32_t e = A.begin[size_t(j)]; e < A.begin[size_t(j) + 1]; ++e) {
      D(A.row[size_t(e)], j) = A.value[size_t(e)];
      D(j, A.row[size_t(e)]) = A.value[size_t(e)];
    }
  return D;
}

/// The operator, column by column, over the rows of `A`.
Eigen::MatrixXd operator_of(const ScalarCycle& c, const fem::ScalarMatrix& A) {
  NodeArray r(c.model().X_mm.size()), z(r.size());
  ScalarCycle::Work work;
  Eigen::MatrixXd M(A.n(), A.n());
  for (int32_t j = 0; j < A.n(); ++j) {
    r.zero();
    r[size_t(A.node_of_row[size_t(j)])] = {1, 2, -1, 0};
    c.apply(r, z, work, test::engine());
    for (int32_t i = 0; i < A.n(); ++i) {
      const Node4& v = z[size_t(A.node_of_row[size_t(i)])];
      M(i, j) = double(v.x);
      EXPECT_EQ(v.y, 2 * v.x);  // one operator for x, y and z
      EXPECT_EQ(v.z, -v.x);
    }
  }
  return M;
}

struct Spectrum {
  double asymmetry, smallest, largest;  // of M; of M A
};
Spectrum spectrum(const std::shared_ptr<const FemModel>& m, const std::vector<fem::SpringRow>& springs) {
  const fem::ScalarMatrix A = fem::assemble_scalar(*m, springs, 0);
  const auto c = ScalarCycle::build(m, springs, 0);
  const Eigen::MatrixXd M = operator_of(*c, A), D = dense(A);
  const Eigen::MatrixXd L = D.llt().matrixL();
  const Eigen::MatrixXd S = L.transpose() * (0.5 * (M + M.transpose())) * L;  // similar to M A
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eig(S, Eigen::EigenvaluesOnly);
  return {(M - M.transpose()).norm() / M.norm(), eig.eigenvalues().minCoeff(), eig.eigenvalues().maxCoeff()};
}

BoxSpec box(Int3 cells, bool fix_sides = true) {
  BoxSpec b;
  b.cells = cells, b.size_mm = Vec3(3.0 * cells.x, 2.7 * cells.y, 2.5 * cells.z);
  b.young_bottom_kPa = 18, b.fix_sides = fix_sides;
  return b;
}

std::shared_ptr<const FemModel> with_hole() {
  BoxSpec b = box({12, 10, 2});
  b.hole_length_mm = 18, b.hole_width_mm = 9;
  return std::make_shared<FemModel>(box_model(b));
}

// With x the smoother S and the coarse correction B exact, the eigenvalues of M A lie in (0, 1] (an error is never made
// larger in energy); the lower end is 1 - the convergence factor.
TEST(Cycle, IsSymmetricPositiveDefiniteAndCloseToTheInverse) {
  std::vector<std::pair<const char*, std::shared_ptr<const FemModel>>> models;
  models.push_back({"odd layers", std::make_shared<FemModel>(box_model(box({8, 7, 3})))});
  models.push_back({"even layers", std::make_shared<FemModel>(box_model(box({7, 8, 4})))});
  models.push_back({"one layer", std::make_shared<FemModel>(box_model(box({9, 9, 1})))});
  models.push_back({"hole", with_hole()});
  models.push_back({"through cut", std::make_shared<FemModel>(test::cut_at_x0(box_model(box({10, 9, 3})), 8))});
  models.push_back(
      {"cut off the coarse lattice", std::make_shared<FemModel>(test::cut_at_x0(box_model(box({6, 9, 3})), 8))});
  for (uint64_t seed = 1; seed < 5; ++seed) {
    Random r(seed);
    test::CutBox cut(box({8, 8, 3}));
    for (int k = 0; k < 6; ++k) cut.cut(r);
    models.push_back({"random cuts", cut.model()});
  }
  for (const auto& [name, m] : models) {
    const Spectrum s = spectrum(m, {});
    EXPECT_LT(s.asymmetry, 1e-5) << name;  // single precision, sums of some hundred terms
    EXPECT_GT(s.smallest, 0.15) << name;   // measured 0.22 and more
    EXPECT_LT(s.largest, 1 + 1e-3) << name;
  }
}

TEST(Cycle, FollowsCellsThatAreDivided) {
  const auto whole = std::make_shared<FemModel>(box_model(box({8, 8, 3})));
  const test::DividedModel d = test::divide(*whole, test::levels_around(*whole, {0, 0, 7.5}, 1.2));
  const auto divided = std::make_shared<FemModel>(d.model);
  ASSERT_FALSE(divided->hanging.empty());
  const Spectrum s = spectrum(divided, {});
  EXPECT_LT(s.asymmetry, 1e-5);
  EXPECT_GT(s.smallest, 0.15);  // measured 0.23
  EXPECT_LT(s.largest, 1 + 1e-3);
  // Through the division, and through a cut across it.
  const auto before = ScalarCycle::build(whole, {}, 0);
  const auto carried = ScalarCycle::rebuild(*before, divided, d.cell_parent, {}, 0);
  EXPECT_TRUE(carried->same_matrices(*ScalarCycle::rebuild(*before, divided, {}, {}, 0)));
  EXPECT_LT(carried->made().rows, carried->made().of_rows);
}

TEST(Cycle, StaysPositiveWithStiffSpringsInside) {
  Random r(3);
  test::CutBox cut(box({8, 8, 3}));
  for (int k = 0; k < 4; ++k) cut.cut(r);
  std::vector<fem::SpringRow> springs;
  for (int i = 0; i < 12; ++i) springs.push_back(cut.spring(r, i));
  const Spectrum s = spectrum(cut.model(), springs);
  EXPECT_LT(s.asymmetry, 1e-4);
  EXPECT_GT(s.smallest, 0.05);  // measured 0.13: the springs are some 20 times stiffer than a cell
  EXPECT_LT(s.largest, 1 + 1e-3);
}

/// Largest factor by which a step of x += M (b - A x) shrinks
/// the energy of the error: power iteration from a fixed start.
double convergence_factor(const std::shared_ptr<const FemModel>& m) {
  const auto c = ScalarCycle::build(m, {}, 0);
  const std::vector<uint8_t> free = fem::free_nodes(*m);
  const fem::NodeMatrix A = fem::assemble_rows(*m, {}, 0, free);
  const fem::RowGroups G = fem::group_rows(A.rows(), A.begin.data(), A.column.data(), A.value.data());
  const size_t n = free.size(), groups = (n + 3) / 4;
  fem::PaddedNodes e;
  e.resize(n);
  Random r(1);
  for (size_t i = 0; i < n; ++i)
    if (free[i]) e.data()[i] = {float(r.uniform()), float(r.uniform()), float(r.uniform()), 0};
  NodeArray zero(n), t(n), z(n), now(n);
  ScalarCycle::Work work;
  double factor = 0;
  for (int k = 0; k < 40; ++k) {
    test::engine().kernels().residual(G.view(), zero.data(), e.data(), t.data(), 0, groups);  // -A e
    std::copy(e.data(), e.data() + n, now.data());
    const double before = -test::engine().dot(now, t);
    c->apply(t, z, work, test::engine());
    test::engine().add_scaled(now, 1, z);
    std::copy(now.data(), now.data() + n, e.data());
    test::engine().kernels().residual(G.view(), zero.data(), e.data(), t.data(), 0, groups);
    const double after = -test::engine().dot(now, t);
    factor = std::sqrt(after / before);
    const double scale = 1 / std::sqrt(after);
    for (size_t i = 0; i < n; ++i) store(e.data()[i], float(scale) * load(e.data()[i]));
  }
  return factor;
}

TEST(Cycle, ConvergesAtARateThatDoesNotDependOnSize) {
  struct Size {
    int side, layers;
  };
  for (const Size s : {Size{24, 2}, {44, 3}, {66, 6}}) {
    const FemModel m = bench_scene(s.side, s.layers, 0.49).model;
    const double whole = convergence_factor(std::make_shared<FemModel>(m));
    const double cut = convergence_factor(std::make_shared<FemModel>(test::cut_at_x0(m, 45)));
    EXPECT_LT(whole, 0.84);  // measured 0.815 to 0.817 at every size, cut or not
    EXPECT_LT(cut, 0.84);
  }
}

// A zone of quarter cells is thinned step by step: at once, 64 cells to one and more, no smoother makes up for it.
TEST(Cycle, ThinsAGradedLatticeStepByStep) {
  const auto whole = std::make_shared<FemModel>(box_model(box({18, 18, 4})));
  test::DividedModel d = test::divide(*whole, test::levels_around(*whole, {0, 0, 5}, 5));
  d.model.graded = true;
  const auto graded = std::make_shared<FemModel>(d.model);
  d.model.graded = false;
  const auto at_once = std::make_shared<FemModel>(std::move(d.model));
  EXPECT_LT(convergence_factor(graded), 0.84);  // as uniform lattices
  EXPECT_GT(convergence_factor(at_once), 0.9);
  // Carried over from the lattice before the division, and from a graded one before a change of springs.
  const auto before = ScalarCycle::build(whole, {}, 0);
  const auto carried = ScalarCycle::rebuild(*before, graded, d.cell_parent, {}, 0);
  EXPECT_TRUE(carried->same_matrices(*ScalarCycle::build(graded, {}, 0)));
  const auto again = ScalarCycle::rebuild(*carried, graded, {}, {}, 0);
  EXPECT_TRUE(again->same_matrices(*carried));
  EXPECT_EQ(again->made().rows, 0);

  const auto small = std::make_shared<FemModel>(box_model(box({8, 8, 3})));
  test::DividedModel e = test::divide(*small, test::levels_around(*small, {0, 0, 7.5}, 1.2));
  e.model.graded = true;
  const Spectrum s = spectrum(std::make_shared<FemModel>(std::move(e.model)), {});
  EXPECT_LT(s.asymmetry, 1e-5);
  EXPECT_GT(s.smallest, 0.15);
  EXPECT_LT(s.largest, 1 + 1e-3);
}

TEST(Cycle, CarriedOverIsTheSameToTheBit) {
  int reused = 0, rebuilt = 0;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    Random r(seed);
    const BoxSpec spec = box(seed % 2 ? Int3{14, 13, 3} : Int3{12, 12, 4}, seed % 3 != 0);
    test::CutBox body(spec);
    struct State {
      test::CutBox body;
      std::shared_ptr<const ScalarCycle> cycle;
      std::vector<std::pair<int, Random>> springs;
    };
    std::vector<State> history;
    std::vector<std::pair<int, Random>> springs;  // drawn again in every model: some keep their nodes, others do not
    const auto rows = [&] {
      std::vector<fem::SpringRow> out;
      for (auto [id, draw] : springs) out.push_back(body.spring(draw, id));
      return out;
    };
    auto cycle = ScalarCycle::build(body.model(), {}, 0);
    for (int k = 0; k < 14; ++k) {
      const double what = r.uniform();
      if (what < -0.7 && !history.empty()) {  // undo: the model of then, with its own cycle
        body = history.back().body, cycle = history.back().cycle, springs = history.back().springs;
        history.pop_back();
        continue;
      }
      history.push_back({body, cycle, springs});
      if (what < 0.6)
        body.cut(r);
      else
        body.excise(r);
      if (r.uniform() < 0) springs.push_back({int(springs.size()), r});
      if (r.uniform() < -0.8 && !springs.empty()) springs.erase(springs.begin());
      const auto carried = ScalarCycle::rebuild(*cycle, body.model(), body.cell_parent(), rows(), 0);
      const auto afresh = ScalarCycle::rebuild(*cycle, body.model(), {}, rows(), 0);  // no parents: all made again
      ASSERT_TRUE(carried->same_matrices(*afresh)) << "seed " << seed << ", step " << k;
      EXPECT_EQ(afresh->made().rows, afresh->made().of_rows);
      reused += carried->made().of_rows - carried->made().rows;
      rebuilt += carried->made().rows;
      Random draw(77);
      NodeArray a(body.model()->X_mm.size()), za(a.size()), zb(a.size());
      for (size_t i = 0; i < a.size(); ++i)
        if (!body.model()->fixed[i]) a[i] = {float(draw.uniform()), float(draw.uniform()), float(draw.uniform()), 0};
      ScalarCycle::Work work;
      carried->apply(a, za, work, test::engine()), afresh->apply(a, zb, work, test::engine());
      for (size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(za[i].x == zb[i].x && za[i].y == zb[i].y && za[i].z == zb[i].z);
      cycle = carried;
    }
  }
  EXPECT_GT(reused, rebuilt);  // most rows are copied even on these small blocks with long cuts
}

// A piece that nothing holds has a singular matrix; the shift keeps the operator finite and definite.
TEST(Cycle, FloatingAndHeldPiecesAndEmptyOnes) {
  BoxSpec b = box({6, 6, 2}, false);
  const auto floating = std::make_shared<FemModel>(box_model(b));
  NodeArray r(floating->X_mm.size()), z(r.size());
  Random draw(5);
  for (size_t i = 0; i < r.size(); ++i) r[i] = {float(draw.uniform()), float(draw.uniform()), float(draw.uniform()), 0};
  ScalarCycle::Work work;
  ScalarCycle::build(floating, {}, 0)->apply(r, z, work, test::engine());
  EXPECT_TRUE(test::engine().all_finite(z));
  EXPECT_GT(test::engine().dot(r, z), 0);

  auto held = std::make_shared<FemModel>(*floating);
  held->fixed.assign(held->fixed.size(), 1);
  ScalarCycle::build(held, {}, 0)->apply(r, z, work, test::engine());  // nothing is free
  EXPECT_EQ(test::engine().max_node(z), 0);
  held->fixed[7] = 0;  // one node
  NodeArray one(r.size());
  one[7] = {1, 0, 0, 0};
  ScalarCycle::build(held, {}, 0)->apply(one, z, work, test::engine());
  EXPECT_TRUE(test::engine().all_finite(z));
  EXPECT_GT(z[7].x, 0);

  ScalarCycle::build(std::make_shared<FemModel>(), {}, 0);
  const auto dynamic = ScalarCycle::build(floating, {}, 1e4);  // inertia holds it
  dynamic->apply(r, z, work, test::engine());
  EXPECT_GT(test::engine().dot(r, z), 0);
}

TEST(Dissection, CostsNoMoreFillThanAGraphPartitioner) {
  for (const int side : {24, 44}) {
    const FemModel m = test::cut_at_x0(bench_scene(side, 3, 0.45).model, 30);
    const std::vector<uint8_t> free = fem::free_nodes(m);
    const fem::ScalarMatrix A = fem::lower_columns(fem::assemble_rows(m, {}, 0, free), fem::floating_shift);
    const fem::GridLevel g = fem::grid_level(m, m.X_mm[0], free);
    std::vector<int32_t> order;
    for (int32_t v : fem::dissection_order(g.at))
      if (A.row_of_node[size_t(v)] >= 0) order.push_back(A.row_of_node[size_t(v)]);
    ASSERT_EQ(int32_t(order.size()), A.n());
    const double own = double(fem::factorize(A, order).panels.bytes()),
                 metis = double(fem::factorize(A, test::engine().workers()).panels.bytes());
    EXPECT_LT(own, 1.3 * metis);
  }
}

}  // namespace test_cycle
}  // namespace limberg
