// Panel solves, the scalar matrix, Woodbury springs, and which operator is in use when.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "cut_models.h"
#include "sim/fem/preconditioner/preconditioner.h"

namespace limberg {
namespace test_preconditioner {

using test::Random;

FemModel model() {
  BoxSpec b;
  b.cells = {6, 6, 3}, b.size_mm = {20, 24, 8}, b.young_bottom_kPa = 18, b.fix_sides = true;
  return box_model(b);
}

Eigen::MatrixXd dense(const fem::ScalarMatrix& A) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(A.n(), A.n());
  for (int32_t j = 0; j < A.n(); ++j)
    for (int32_t e = A.begin[size_t(j)]; e < A.begin[size_t(j) + 1]; ++e) {
      D(A.row[size_t(e)], j) = A.value[size_t(e)];
      D(j, A.row[size_t(e)]) = A.value[size_t(e)];
    }
  return D;
}

NodeArray random_nodes(const FemModel& m, uint64_t seed) {
  Random r(seed);
  NodeArray a(m.X_mm.size());
  for (size_t i = 0; i < a.size(); ++i)
    if (!m.fixed[i]) a[i] = {float(r.uniform()), float(r.uniform()), float(r.uniform()), 0};
  return a;
}

std::vector<fem::Preconditioner::SpringEntry> springs(const FemModel& m, int count) {
  std::vector<fem::Preconditioner::SpringEntry> s;
  Random r(9);
  for (int i = 0; i < count; ++i) {
    Spring p;
    p.id = i, p.k_N_per_mm = 20;
    p.a = embed(m, r.vector(6) + Vec3(0, 0, 4)), p.b = embed(m, r.vector(6) + Vec3(0, 0, 4));
    s.push_back({fem::spring_row(m, p), true});
  }
  return s;
}

/// Largest relative error of M z = r, column by column, in the dense matrix D over A's rows.
double solve_error(const fem::ScalarMatrix& A, const Eigen::MatrixXd& D, const NodeArray& r, const NodeArray& z) {
  Eigen::MatrixXd R(A.n(), 3), Z(A.n(), 3);
  for (int32_t i = 0; i < A.n(); ++i) {
    const Node4 a = r[size_t(A.node_of_row[size_t(i)])], b = z[size_t(A.node_of_row[size_t(i)])];
    R.row(i) << a.x, a.y, a.z;
    Z.row(i) << b.x, b.y, b.z;
  }
  const Eigen::MatrixXd exact = D.ldlt().solve(R);
  return (Z - exact).norm() / exact.norm();
}

TEST(Preconditioner, IsTheInverseOfTheScalarMatrix) {
  InlineWorkers w;
  const auto m = std::make_shared<FemModel>(model());
  fem::Preconditioner P(w);
  P.set_model(m, {});
  P.begin_step(0, 3, false);
  const NodeArray r = random_nodes(*m, 1);
  NodeArray z(r.size());
  P.apply(r, z);
  const auto A = fem::assemble_scalar(*m, {}, 0);
  EXPECT_LT(solve_error(A, dense(A), r, z), 1e-5);
}

TEST(Preconditioner, SpringsBesideAndInsideTheFactorAreTheSameOperator) {
  InlineWorkers w;
  const auto m = std::make_shared<FemModel>(model());
  const auto s = springs(*m, 7);
  fem::Preconditioner beside(w), inside(w);
  beside.set_model(m, {}), inside.set_model(m, {});
  beside.begin_step(0, 3, false);
  beside.set_springs(s), inside.set_springs(s);
  beside.begin_step(0, 3, false), inside.begin_step(0, 3, false);
  const NodeArray r = random_nodes(*m, 2);
  NodeArray zb(r.size()), zi(r.size());
  beside.apply(r, zb), inside.apply(r, zi);
  std::vector<fem::SpringRow> rows;
  for (const auto& e : s) rows.push_back(e.row);
  const auto A = fem::assemble_scalar(*m, rows, 0);
  // Springs are some 300 times stiffer than a cell, single precision loses as much.
  EXPECT_LT(solve_error(A, dense(A), r, zb), 1e-3);
  EXPECT_LT(solve_error(A, dense(A), r, zi), 1e-3);
}

TEST(Preconditioner, ACutIsAnsweredByTheCycleUntilTheFactorIsThere) {
  InlineWorkers w;
  const auto before = std::make_shared<FemModel>(model());
  const auto after = std::make_shared<FemModel>(test::cut_at_x0(*before, 6));
  ASSERT_GT(after->X_mm.size(), before->X_mm.size());
  fem::Preconditioner P(w);
  P.set_model(before, {});
  P.begin_step(0, 3, false);
  EXPECT_FALSE(P.on_cycle());
  EXPECT_EQ(P.cycle(), nullptr);  // nothing that is not needed yet
  P.set_model(after, test::identity_parents(*after));
  P.begin_step(0, 3, false);
  EXPECT_TRUE(P.on_cycle());
  const NodeArray a = random_nodes(*after, 3), b = random_nodes(*after, 4);
  NodeArray za(a.size()), zb(a.size());
  P.apply(a, za), P.apply(b, zb);
  EXPECT_NEAR(test::engine().dot(a, zb), test::engine().dot(b, za),
              1e-5 * std::sqrt(test::engine().dot(a, za) * test::engine().dot(b, zb)));
  // Forces that open the cut are answered as the new topology answers them.
  NodeArray open(a.size()), z(a.size()), exact(a.size());
  for (size_t i = before->X_mm.size(); i < a.size(); ++i) open[i].x = 1, open[size_t(after->parent[i])].x = -1;
  P.apply(open, z);
  P.begin_step(0, 3, false), P.begin_step(0, 3, false), P.begin_step(0, 3, false);
  EXPECT_FALSE(P.on_cycle());
  P.apply(open, exact);
  EXPECT_GT(test::engine().dot(open, z), 0.3 * test::engine().dot(open, exact));  // measured 0.48
  EXPECT_LT(test::engine().dot(open, z), 1.001 * test::engine().dot(open, exact));
  P.apply(a, za);
  const auto A = fem::assemble_scalar(*after, {}, 0);
  EXPECT_LT(solve_error(A, dense(A), a, za), 1e-5);
}

TEST(Preconditioner, ALargeModelNeverWaitsForAFactor) {
  InlineWorkers w;
  const auto before = std::make_shared<FemModel>(bench_scene(16, 2, 0.45).model);
  const auto after = std::make_shared<FemModel>(test::cut_at_x0(*before, 35));
  fem::Preconditioner P(w, {100});
  P.set_model(before, {});
  P.begin_step(0, 3, false);
  EXPECT_TRUE(P.on_cycle() && !P.pending());
  const auto first = P.cycle();
  P.set_springs(springs(*before, 20));  // more than are left beside
  P.begin_step(0, 3, false);
  EXPECT_EQ(P.cycle()->springs().size(), 20u);
  EXPECT_LT(P.cycle()->made().rows, P.cycle()->made().of_rows);
  P.set_model(after, test::identity_parents(*after));
  P.begin_step(0, 3, false);
  EXPECT_TRUE(P.on_cycle() && !P.pending());
  EXPECT_LT(P.cycle()->made().rows, P.cycle()->made().of_rows);
  // An undo finds the operator of before.
  P.set_model(before, {});
  EXPECT_EQ(P.cycle()->springs().size(), 20u);
  P.begin_step(0, 3, false);
  EXPECT_EQ(&P.cycle()->model(), before.get());
  EXPECT_TRUE(P.cycle()->springs().empty());  // the sutures of then are gone, so they are taken out
  EXPECT_TRUE(P.cycle()->same_matrices(*first));
}

TEST(Preconditioner, AnUndoFindsItsFactorAgain) {
  InlineWorkers w;
  const auto before = std::make_shared<FemModel>(model());
  const auto after = std::make_shared<FemModel>(test::cut_at_x0(*before, 6));
  fem::Preconditioner P(w);
  P.set_model(before, {});
  P.begin_step(0, 3, false);
  P.set_model(after, test::identity_parents(*after));
  P.begin_step(0, 3, false);
  EXPECT_TRUE(P.pending());
  P.set_model(before, {});
  P.begin_step(0, 3, false);
  EXPECT_FALSE(P.pending() || P.on_cycle());
  const NodeArray r = random_nodes(*before, 1);
  NodeArray z(r.size());
  P.apply(r, z);
  const auto A = fem::assemble_scalar(*before, {}, 0);
  EXPECT_LT(solve_error(A, dense(A), r, z), 1e-5);
}

// Cut after cut, faster than factors are made: which of them are used depends on steps, never on how fast a job was.
TEST(Preconditioner, QuickCutsGiveTheSameBitsForAnyNumberOfWorkers) {
  const auto run = [](Workers& w) {
    BoxSpec b;
    b.cells = {14, 12, 3}, b.size_mm = {42, 36, 9}, b.fix_sides = true;
    test::CutBox body(b);
    Random r(4);
    fem::Preconditioner P(w);
    P.set_model(body.model(), {});
    P.begin_step(0, 3, false);
    std::vector<float> out;
    for (int cut = 0; cut < 6; ++cut) {
      body.cut(r);
      P.set_model(body.model(), body.cell_parent());
      for (int step = 0; step < (cut == 4 ? 5 : 2); ++step) {
        P.begin_step(0, 3, false);
        const NodeArray a = random_nodes(*body.model(), uint64_t(10 * cut + step));
        NodeArray z(a.size());
        P.apply(a, z);
        for (const Node4& v : z) out.push_back(v.x), out.push_back(v.z);
      }
      EXPECT_EQ(P.on_cycle(), cut != 4);
    }
    return out;
  };
  InlineWorkers one;
  test::ThreadWorkers two(2), three(3);
  const std::vector<float> a = run(one);
  EXPECT_EQ(a, run(two));
  EXPECT_EQ(a, run(three));
}

// Made beside other work, before the step that would make it: the same operators, a factor on its way or none.
TEST(Preconditioner, MadeReadyItIsTheSame) {
  for (const int32_t factor_up_to : {0, 10000}) {
    const auto run = [&](bool ready) {
      InlineWorkers w;
      BoxSpec b;
      b.cells = {14, 12, 3}, b.size_mm = {42, 36, 9}, b.fix_sides = true;
      test::CutBox body(b);
      Random r(4);
      fem::Preconditioner P(w, {factor_up_to});
      std::vector<float> out;
      std::vector<int32_t> made;
      for (int cut = 0; cut < 6; ++cut) {
        if (cut > 0) body.cut(r);
        P.set_model(body.model(), cut > 0 ? ParentList(body.cell_parent()) : ParentList{});
        P.set_springs(springs(*body.model(), 3 * cut));
        if (ready) P.make_ready(0);
        const auto before = P.cycle();
        for (int step = 0; step < 5; ++step) {
          if (ready && step == 2) P.make_ready(0);
          P.begin_step(0, 3, false);
          if (ready && cut > 0 && step == 0) {
            EXPECT_EQ(P.cycle(), before) << "made in the step";
          }
          made.push_back(P.cycle() ? P.cycle()->made().rows : -1);
          const NodeArray a = random_nodes(*body.model(), uint64_t(10 * cut + step));
          NodeArray z(a.size());
          P.apply(a, z);
          for (const Node4& v : z) out.push_back(v.x), out.push_back(v.z);
        }
      }
      return std::pair(out, made);
    };
    const auto with = run(true), without = run(false);
    EXPECT_EQ(with.second, without.second);
    EXPECT_EQ(with.first, without.first);
  }
}

TEST(Preconditioner, InheritedOrderCostsLittleFill) {
  const FemModel before = bench_scene(24, 2, 0.45).model;
  const FemModel after = test::cut_at_x0(before, 20);
  const auto A0 = fem::assemble_scalar(before, {}, 0), A1 = fem::assemble_scalar(after, {}, 0);
  Workers& workers = test::engine().workers();
  const auto F0 = fem::factorize(A0, workers), best = fem::factorize(A1, workers);
  const auto inherited = fem::factorize(A1, fem::inherited_order(A1, F0.node_order, after.parent.flat()));
  EXPECT_LT(double(inherited.panels.bytes()), 1.3 * double(best.panels.bytes()));  // measured before: 1.1
}

TEST(NodeVectors, SumsAndSmallOperations) {
  Random r(6);
  NodeArray a(1001), b(1001);
  double exact = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    a[i] = {float(r.uniform()), float(r.uniform()), float(r.uniform()), 0};
    b[i] = {float(r.uniform()), float(r.uniform()), float(r.uniform()), 0};
    exact += double(a[i].x) * b[i].x + double(a[i].y) * b[i].y + double(a[i].z) * b[i].z;
  }
  EXPECT_NEAR(test::engine().dot(a, b), exact, 1e-4);  // 3000 terms of 1 in blocks of single precision
  NodeArray c = a;
  EXPECT_NEAR(test::engine().add_scaled_dot(c, 0.5, b, b), exact + 0.5 * test::engine().dot(b, b), 1e-3);
  EXPECT_FLOAT_EQ(c[77].y, a[77].y + 0.5f * b[77].y);
  EXPECT_TRUE(test::engine().all_finite(c));
  c[1000].z = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(test::engine().all_finite(c));
  c[1000].z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(test::engine().all_finite(c));
  EXPECT_TRUE(std::isnan(test::engine().max_node(c)));
}

}  // namespace test_preconditioner
}  // namespace limberg
