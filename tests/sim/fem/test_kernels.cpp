// The kernels of every instruction set that this machine has: the same bits from each, with any number of threads.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <tuple>
#include <vector>

#include "models.h"
#include "sim/fem/elements/element_system.h"
#include "sim/fem/preconditioner/cholesky.h"
#include "sim/fem/solver/cycle.h"
#include "sim/fem/solver/lbfgs_solver.h"

namespace limberg {
namespace test_kernels {

using fem::Engine;
using fem::Kernels;
using test::Random;

NodeArray random_nodes(size_t n, double size, uint64_t seed) {
  Random r(seed);
  NodeArray a(n);
  for (auto& v : a) {
    const Vec3 x = r.vector(size);
    v = {float(x[0]), float(x[1]), float(x[2]), 0};
  }
  return a;
}

bool same_bits(const NodeArray& a, const NodeArray& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Node4)) == 0;
}

FemModel block(Int3 cells) {
  BoxSpec b;
  b.cells = cells, b.size_mm = {60, 60, 10}, b.young_bottom_kPa = 18, b.poisson = 0.49, b.fix_sides = true,
  b.hole_length_mm = 20, b.hole_width_mm = 6;
  FemModel m = box_model(b);
  m.stencils[0].sample = {0.4, 0.5, 0.7};                               // both ways to sample the volume
  m.stencils[1].sample = {0.5, 0.5, 0.3}, m.stencils[1].slide_kPa = 5;  // shared by layers
  m.stencils.push_back(m.stencils[0]);
  m.stencils[2].sample = {0.5, 0.5, 0.5};
  Random r(8);  // runs of one stencil of every length: some are taken a cell to a lane, which ones is up to the set
  for (size_t i = 0; i < m.cells.size();) {
    const int32_t stencil = int32_t(1.5 * (r.uniform() + 1));
    for (size_t end = std::min(m.cells.size(), i + 1 + size_t(10 * (r.uniform() + 1))); i < end; ++i)
      m.cells[i].stencil = stencil;
  }
  return m;
}

template <class Test>
void for_every_set(const Test& test) {
  for (const Kernels* k : fem::available_kernels()) {
    SCOPED_TRACE(k->name);
    test(*k);
  }
}

TEST(Kernels, PlainIsAlwaysThereAndUnknownNamesAreNot) {
  EXPECT_STREQ(fem::available_kernels().front()->name, "plain");
  EXPECT_EQ(fem::find_kernels("sse9"), nullptr);
  EXPECT_EQ(fem::find_kernels("plain"), fem::available_kernels().front());
}

TEST(Kernels, CellsAgree) {
  const auto m = std::make_shared<FemModel>(block({31, 29, 5}));
  const NodeArray u = random_nodes(m->X_mm.size(), 0.7, 1);
  test::ThreadWorkers four(4);
  for (bool measure : {false, true}) {
    NodeArray expected(u.size());
    fem::CellSums sums;
    float theta = 0;
    for_every_set([&](const Kernels& k) {
      InlineWorkers one;
      fem::ElementSystem cells(m);
      NodeArray g(u.size()), again(u.size()), threads(u.size());
      for (int round = 0; round < 2; ++round) {
        cells.evaluate(u, g, measure, Engine(one, k));
        cells.update_multipliers(Engine(one, k));
      }
      const fem::CellSums s = cells.evaluate(u, g, measure, Engine(one, k)),
                          t = cells.evaluate(u, threads, measure, Engine(four, k));
      cells.evaluate(u, again, measure, Engine(one, k));
      EXPECT_TRUE(same_bits(g, again));
      EXPECT_TRUE(same_bits(g, threads));
      EXPECT_EQ(s.energy, t.energy);
      if (expected[7].x == 0) expected = g, sums = s, theta = cells.theta(100);
      EXPECT_TRUE(same_bits(g, expected));
      EXPECT_EQ(s.energy, sums.energy);
      EXPECT_EQ(s.magnitude, sums.magnitude);
      EXPECT_EQ(cells.theta(100), theta);
    });
  }
}

// Where each cell has a stencil of its own they are taken a cell to a lane all the same: same bits as one by one.
TEST(Kernels, CellsOfTheirOwnStencilsAreTakenTogetherWithTheSameBits) {
  FemModel m = block({31, 29, 5});
  const std::vector<Stencil> kinds{m.stencils[0], m.stencils[1], m.stencils[2]};
  Random r(12);
  for (size_t i = 0; i < m.cells.size(); ++i) {
    if (r.uniform() < -0.4) continue;  // some stay in runs of one
    Stencil own = kinds[size_t(1.5 * (r.uniform() + 0.999))];
    own.K *= 1.5 + r.uniform(), own.volume_mm3 *= 1.5 + r.uniform(), own.lambda_kPa *= 1.5 + r.uniform();
    if (own.slide_kPa == 0 && own.sample != Vec3::Constant(0.5)) own.sample = {0.5, 0.5 + 0.3 * r.uniform(), 0.6};
    m.cells[i].stencil = int32_t(m.stencils.size()), m.stencils.push_back(own);
  }
  const auto model = std::make_shared<FemModel>(m);
  const NodeArray u = random_nodes(m.X_mm.size(), 0.7, 1);
  const fem::ElementSystem system(model);
  const fem::KernelData& data = system.kernel();
  std::array<size_t, fem::LaneBlock::none> together{};
  for (const auto& lanes : data.lanes)
    if (lanes)
      for (auto kind : lanes->kind)
        if (kind != fem::LaneBlock::none) ++together[kind];
  for (size_t n : together) EXPECT_GT(n, 500u);
  AlignedArray<float> q(m.cells.size());
  for (float& x : q) x = float(0.1 * r.uniform());
  for (bool measure : {false, true})
    for_every_set([&](const Kernels& k) {
      const auto evaluate = [&](bool lanes) {
        NodeArray slots(data.slot_node.size());
        AlignedArray<float> theta(m.cells.size());
        std::vector<double> sums;
        for (fem::Tile tile : data.tiles) {
          if (!lanes) tile.lanes = {};
          const fem::CellSums s =
              k.evaluate_tile(data.view(), tile, u.data(), q.data(), slots.data(), theta.data(), measure);
          sums.push_back(s.energy), sums.push_back(s.magnitude);
        }
        return std::tuple(std::move(slots), std::vector<float>(theta.begin(), theta.end()), sums);
      };
      const auto [slots, theta, sums] = evaluate(true);
      const auto [slots_1, theta_1, sums_1] = evaluate(false);
      EXPECT_TRUE(same_bits(slots, slots_1));
      EXPECT_EQ(theta, theta_1);
      EXPECT_EQ(sums, sums_1);
    });
}

TEST(Kernels, VectorsAgree) {
  const size_t n = 10007;
  const NodeArray a = random_nodes(n, 1, 2), b = random_nodes(n, 1, 3);
  test::ThreadWorkers three(3);
  double expected_dot = 0;
  NodeArray expected;
  for_every_set([&](const Kernels& k) {
    InlineWorkers one;
    NodeArray result[2];
    double dots[2];
    for (int threads = 0; threads < 2; ++threads) {
      const Engine e(threads ? static_cast<Workers&>(three) : one, k);
      NodeArray c = a, d(n);
      dots[threads] = e.dot(a, b) + e.add_scaled_dot(c, 0.3, b, a);
      e.combine(d, c, -0.7, b);
      e.subtract(c, d, a);
      e.add_scaled(c, 2, b);
      AlignedArray<float> f(n), g(n);
      for (size_t i = 0; i < n; ++i) f[i] = a[i].x, g[i] = b[i].y;
      const float* columns[3] = {f.data(), g.data(), f.data()};
      NodeArray forces = random_nodes(3, 1, 4);
      e.subtract_outer(c, columns, forces.data(), 3);
      EXPECT_TRUE(e.all_finite(c));
      NodeArray bad = c;
      bad[9000].y = std::nanf("");
      EXPECT_FALSE(e.all_finite(bad));
      EXPECT_TRUE(std::isnan(e.max_node(bad)));
      double most = 0;
      for (const auto& v : c) most = std::max(most, Vec3(double(v.x), double(v.y), double(v.z)).norm());
      EXPECT_NEAR(e.max_node(c), most, 1e-12);
      result[threads] = c;
    }
    EXPECT_TRUE(same_bits(result[0], result[1]));
    EXPECT_EQ(dots[0], dots[1]);
    if (expected.empty()) expected = result[0], expected_dot = dots[0];
    EXPECT_TRUE(same_bits(result[0], expected));
    EXPECT_EQ(dots[0], expected_dot);
  });
}

// Random matrices have no lattice's luck: rows of any length, groups that are not full, supernodes of any shape.
TEST(Kernels, FactorAndCycleAgree) {
  const auto m = std::make_shared<FemModel>(block({44, 43, 4}));
  const fem::ScalarMatrix A = fem::assemble_scalar(*m, {}, 0);
  const fem::ScalarFactor F = fem::factorize(A, test::engine().workers());
  const auto cycle = fem::ScalarCycle::build(m, {}, 0);
  const std::vector<uint8_t> free = fem::free_nodes(*m);
  NodeArray r = random_nodes(free.size(), 1, 5), b = random_nodes(size_t(A.n()), 1, 6);
  for (size_t i = 0; i < free.size(); ++i)
    if (!free[i]) r[i] = {};
  test::ThreadWorkers three(3);
  NodeArray expected_y, expected_z;
  for_every_set([&](const Kernels& k) {
    InlineWorkers one;
    NodeArray y[2], z[2];
    for (int threads = 0; threads < 2; ++threads) {
      const Engine e(threads ? static_cast<Workers&>(three) : one, k);
      y[threads] = b, z[threads] = NodeArray(free.size());
      F.panels.solve(y[threads].data(), e);
      fem::ScalarCycle::Work work;
      cycle->apply(r, z[threads], work, e);
    }
    EXPECT_TRUE(same_bits(y[0], y[1]));
    EXPECT_TRUE(same_bits(z[0], z[1]));
    if (expected_y.empty()) expected_y = y[0], expected_z = z[0];
    EXPECT_TRUE(same_bits(y[0], expected_y));
    EXPECT_TRUE(same_bits(z[0], expected_z));
  });
  // And the solve is one: A y = b.
  std::vector<Vec3> product(size_t(A.n()), Vec3::Zero());
  const auto x = [&](int32_t row, const std::vector<int32_t>& place) {
    const Node4& v = expected_y[size_t(place[size_t(A.node_of_row[size_t(row)])])];
    return Vec3(double(v.x), double(v.y), double(v.z));
  };
  std::vector<int32_t> place(free.size(), -1);
  for (size_t i = 0; i < F.node_order.size(); ++i) place[size_t(F.node_order[i])] = int32_t(i);
  for (int32_t j = 0; j < A.n(); ++j)
    for (int32_t e = A.begin[size_t(j)]; e < A.begin[size_t(j) + 1]; ++e) {
      const int32_t i = A.row[size_t(e)];
      product[size_t(i)] += A.value[size_t(e)] * x(j, place);
      if (i != j) product[size_t(j)] += A.value[size_t(e)] * x(i, place);
    }
  double wrong = 0, size = 0;
  for (int32_t i = 0; i < A.n(); ++i) {
    const Node4& v = b[size_t(place[size_t(A.node_of_row[size_t(i)])])];
    const Vec3 wanted(double(v.x), double(v.y), double(v.z));
    wrong += (product[size_t(i)] - wanted).squaredNorm(), size += wanted.squaredNorm();
  }
  EXPECT_LT(std::sqrt(wrong / size), 1e-4);  // float times the matrix's condition
}

TEST(Kernels, WholeStepsAgreeAndDoNotDependOnTheWorkers) {
  BenchScene scene = bench_scene(30, 3, 0.49);
  const auto m = std::make_shared<FemModel>(scene.model);
  scene.springs.back().target_mm += Vec3(-3, -3, 8);
  test::ThreadWorkers three(3);
  for (int32_t factor_up_to : {0, 10000}) {  // the cycle, and the factor
    std::vector<Vec3f> expected;
    for_every_set([&](const Kernels& k) {
      InlineWorkers one;
      fem::LbfgsSolver a(one, true, {factor_up_to, &k}), b(three, true, {factor_up_to, &k});
      StepSettings few, many;
      few.max_iterations = 5, many.max_iterations = 800, many.tolerance = 3e-6;
      for (auto* s : {&a, &b}) s->set_model(m, {}), s->set_springs(scene.springs), s->step(few);
      EXPECT_TRUE(a.save() == b.save());
      EXPECT_TRUE(a.step(many).converged);
      const auto u = a.displacement_mm();
      if (expected.empty()) expected.assign(u.begin(), u.end());
      for (size_t i = 0; i < u.size(); ++i) ASSERT_TRUE(u[i] == expected[i]) << i;
    });
  }
}

}  // namespace test_kernels
}  // namespace limberg
