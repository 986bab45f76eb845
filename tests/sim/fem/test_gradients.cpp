// Derivatives that the minimiser uses itself, in single precision, against central
// differences of its own energies. (Those of the reference solver, of laws, of
// material points, of contacts and of shaped cells are in the tests of these.)
#include <gtest/gtest.h>

#include <cmath>

#include "sim/fem/elements/element_system.h"
#include "sim/fem/forces/spring_forces.h"
#include "tests/sim/fem/models.h"

namespace limberg {
namespace test_gradients {

NodeArray nodes(const std::vector<Vec3>& u) {
  NodeArray a(u.size());
  for (size_t i = 0; i < u.size(); ++i) a[i] = {float(u[i][0]), float(u[i][1]), float(u[i][2]), 0};
  return a;
}

double product(const NodeArray& g, const std::vector<Vec3>& d) {
  double s = 0;
  for (size_t i = 0; i < d.size(); ++i)
    s += double(g[i].x) * d[i][0] + double(g[i].y) * d[i][1] + double(g[i].z) * d[i][2];
  return s;
}

template <class Evaluate>
void check(const FemModel& m, double h, double tolerance, const Evaluate& evaluate) {
  for (uint64_t seed : {1, 2, 3}) {
    const auto u = test::random_displacement(m, 0.5, seed), d = test::random_displacement(m, 1, seed + 10);
    std::vector<Vec3> plus = u, minus = u;
    for (size_t i = 0; i < u.size(); ++i) plus[i] += h * d[i], minus[i] -= h * d[i];
    NodeArray g(u.size()), unused(u.size());
    evaluate(nodes(u), g);
    const double exact = product(g, d),
                 found = (evaluate(nodes(plus), unused) - evaluate(nodes(minus), unused)) / (2 * h);
    double size = 0;
    for (size_t i = 0; i < u.size(); ++i)
      size += std::sqrt(double(g[i].x) * double(g[i].x) + double(g[i].y) * double(g[i].y) +
                        double(g[i].z) * double(g[i].z)) *
              d[i].norm();
    EXPECT_NEAR(found, exact, tolerance * size);
  }
}

TEST(Gradients, Springs) {
  BoxSpec b;
  const FemModel m = box_model(b);
  Spring hook, stitch;
  hook.id = 1, hook.to_world = true, hook.a = embed(m, {1.3, 0.4, 9}), hook.target_mm = {3, 4, 12},
  hook.k_N_per_mm = 0.7;
  stitch.id = 2, stitch.a = embed(m, {-2, 1, 10}), stitch.b = embed(m, {2, -1, 5.5}), stitch.target_mm = {0.1, 0.2, 0},
  stitch.k_N_per_mm = 2;
  Spring bite;  // its ends are means over places of more than one cell
  bite.id = 3, bite.k_N_per_mm = 1.3;
  for (double y : {-2.0, 0.0, 1.5})
    bite.a_wide.push_back(embed(m, {-1, y, 9})), bite.b_wide.push_back(embed(m, {3, y, 8}));
  bite.a_wide[1].share = 2.5, bite.b_wide[2].share = -0.4;
  const std::vector<Spring> springs = {hook, stitch, bite};
  const fem::SpringForces forces(m, springs);
  check(m, 1e-2, 1e-4, [&](const NodeArray& u, NodeArray& g) {
    g.zero();
    return forces.add(u, g, false);
  });
}

// With multipliers that are in the middle of their way: the energy that is minimised is the augmented one.
TEST(Gradients, CellsWithMultipliers) {
  BoxSpec b;
  b.young_bottom_kPa = 18, b.poisson = 0.49;
  const auto m = std::make_shared<FemModel>(box_model(b));
  fem::ElementSystem cells(m);
  NodeArray g(m->X_mm.size());
  cells.evaluate(nodes(test::random_displacement(*m, 0.1, 9)), g, false, test::engine());
  ASSERT_TRUE(cells.update_multipliers(test::engine()));
  check(*m, 1e-2, 2e-3,
        [&](const NodeArray& u, NodeArray& out) { return cells.evaluate(u, out, false, test::engine()).energy; });
}

}  // namespace test_gradients
}  // namespace limberg
