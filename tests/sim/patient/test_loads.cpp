// A patient with weight, loads and sliding sides: signs, balance, cuts, undo.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/lattice/sheet_bodies.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_loads {

StepReport to_rest(World& world, double tolerance = 2e-5, int most = 200) {
  StepSettings s;
  s.max_iterations = 20, s.tolerance = tolerance;
  StepReport r;
  for (int k = 0; k < most && !(r.converged && !r.preconditioner_pending && world.settled()); ++k) r = world.step(s);
  return r;
}

Vec3 moved_mm(const World& world, const ChartPoint& at) {
  Snapshot s;
  world.fill(s);
  double best = 1e300;
  Vec3 move = Vec3::Zero();
  for (size_t v = 0; v < s.x_mm.size(); ++v) {
    const Vec3& X = s.topology->view.X_mm[v];
    const double d = (X.head<2>() - at).squaredNorm() - 1e-3 * X.z();  // of the places there the topmost
    if (d < best) best = d, move = s.x_mm[v].cast<double>() - X;
  }
  return move;
}

// A dome on a flat bed: lying it flattens; standing it hangs, as a short beam does that is held at its foot: the lower
// flank is pressed in and the upper one drawn out.
TEST(Loads, LyingAndStandingShapeACurvedBody) {
  test::Sheet sheet;
  sheet.size_mm = 40, sheet.cells = 20;
  sheet.top = [](double x, double y) { return 16 - (x * x + y * y) / 60; };
  sheet.bottom = [](double, double) { return -4.0; };
  const auto body = std::make_shared<Body>(test::layered(test::sheet_mesh(sheet), 1.5));
  InlineWorkers workers;
  const auto world_of = [&](const Vec3& gravity) {
    WorldSpec spec;
    spec.body = body, spec.cell_mm = 4, spec.can_cut = false, spec.gravity_m_s2 = gravity;
    auto world = std::make_unique<World>(spec, workers);
    EXPECT_LT(to_rest(*world).residual, 1e-4);
    return world;
  };
  const auto lying = world_of({0, 0, -9.81}), standing = world_of({0, -9.81, 0}), hanging = world_of({0, 0, 9.81}),
             weightless = world_of(Vec3::Zero());
  EXPECT_LT(moved_mm(*weightless, {0, 0}).norm(), 1e-3);
  EXPECT_LT(moved_mm(*lying, {0, 0}).z(), -0.02);
  EXPECT_GT(moved_mm(*hanging, {0, 0}).z(), 0.02);
  EXPECT_LT(moved_mm(*standing, {0, 0}).y(), -0.02);
  EXPECT_LT(std::abs(moved_mm(*standing, {0, 0}).x()), 0.005);
  EXPECT_LT(moved_mm(*standing, {0, -12}).z(), -0.01);
  EXPECT_GT(moved_mm(*standing, {0, 12}).z(), 0.01);
  // What it weighs is what its bed gives.
  const double weight_mN = lying->skin()->volume_mm3() * 1e-6 * 9810;
  EXPECT_NEAR(lying->skin()->solver().load_force_mN().z(), -weight_mN, 0.01 * weight_mN);
  EXPECT_NEAR(lying->skin()->solver().support_force_mN().z(), -weight_mN, 0.02 * weight_mN);
}

WorldSpec heavy_block() {
  WorldSpec spec = test::small_block({.side_mm = 50, .cell_mm = 5, .along = 1.05, .across = 1.02});
  spec.gravity_m_s2 = {2, -3, 9.81};  // face down
  spec.loads = {{{-15, 8}, {0.02, 0, 0.05}, 2}, {{14, -12}, {0, 0.1, -0.05}, 3}};
  return spec;
}

// A flap on its pedicle, free of its bed, hangs: judged by the balance of forces, its weight that of the new model.
TEST(Loads, ACutFlapHangsAndBalances) {
  InlineWorkers workers;
  World world(heavy_block(), workers);
  to_rest(world);
  const Vec3 before = moved_mm(world, {0, -6});
  const auto check = [&](const char* when) {
    const StepReport r = to_rest(world);
    EXPECT_LT(r.residual, 1e-4) << when;
    const ElasticSolver& solver = world.skin()->solver();
    Vec3 loads = world.skin()->volume_mm3() * 1e-3 * world.skin()->spec().gravity_m_s2;  // mN: 1e-6 kg/mm^3
    for (const DeadLoad& l : solver.loads()) loads += l.force_mN;
    EXPECT_LT((solver.load_force_mN() - loads).norm(), 2e-3 * loads.norm()) << when;
    double size = 0;
    for (const SupportForce& f : solver.support_forces_mN()) size += f.force_mN.norm();
    EXPECT_LT((solver.load_force_mN() - solver.support_force_mN()).norm(), 1e-3 * size) << when;
  };
  check("whole");
  ASSERT_TRUE(world.apply(Incise{{{-6, 6}, {-6, -8}, {6, -8}, {6, 6}}, 5}).done);
  ASSERT_TRUE(world.apply(Undermine{{{-7, 6}, {-7, -9}, {7, -9}, {7, 6}}, 5}).done);
  check("flap");
  EXPECT_GT((moved_mm(world, {0, -6}) - before).z(), 0.05);
  const double volume = world.skin()->volume_mm3();
  ASSERT_TRUE(world.apply(Excise{{{10, 4}, {18, 4}, {18, 14}, {10, 14}}, 6}).done);
  EXPECT_LT(world.skin()->volume_mm3(), volume - 300);
  check("excised");
}

TEST(Loads, GoWithTheirSkinAndComeBack) {
  InlineWorkers workers;
  World world(heavy_block(), workers);
  to_rest(world);
  ASSERT_EQ(world.skin()->solver().loads().size(), 2u);
  const Vec3 weight = world.skin()->solver().load_force_mN();
  const uint64_t hash = world.full_hash();
  // Beside a load: it stays, on its own bank.
  ASSERT_TRUE(world.apply(Incise{{{-20, 7}, {-10, 7}}, 4}).done);
  ASSERT_EQ(world.skin()->solver().loads().size(), 2u);
  EXPECT_LT(world.skin()->solver().loads()[0].at.size(), 43u) << "a patch does not reach over a wound";
  EXPECT_NEAR((world.skin()->solver().load_force_mN() - weight).norm(), 0, 1e-3 * weight.norm());
  // Around it: it goes with what is taken out.
  ASSERT_TRUE(world.apply(Excise{{{8, -18}, {20, -18}, {20, -6}, {8, -6}}, 5}).done);
  EXPECT_EQ(world.skin()->solver().loads().size(), 1u);
  const uint64_t excised = world.full_hash();
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.skin()->solver().loads().size(), 2u);
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.full_hash(), hash);
  EXPECT_EQ(world.skin()->solver().load_force_mN(), weight);
  ASSERT_TRUE(world.apply(Redo{}).done);
  ASSERT_TRUE(world.apply(Redo{}).done);
  EXPECT_EQ(world.full_hash(), excised);
}

// A block that slides on its sides and is drawn by a load goes along; held, it does not.
TEST(Loads, SidesSlide) {
  InlineWorkers workers;
  BlockSpec b;
  b.size_mm = {30, 30, 10}, b.skin_cell_mm = 2;
  Material m;
  m.young_kPa = 20, m.poisson = 0.3;
  b.layers = {{"tissue", 10, m}};
  const auto sunk = [&](SideHold sides) {
    b.sides = {sides, sides, sides, sides, SideHold::held};
    WorldSpec spec;
    spec.body = std::make_shared<Body>(make_block(b));
    spec.cell_mm = 5, spec.gravity_m_s2 = {0, 0, -20};
    World world(spec, workers);
    EXPECT_LT(to_rest(world, 1e-5).residual, 1e-4);
    const FemModel& f = world.skin()->solver().model();
    for (size_t i = 0; i < f.X_mm.size(); ++i)
      for (int k = 0; k < 3; ++k)
        if (f.fixed[i].along(k)) {
          EXPECT_EQ(world.skin()->solver().displacement_mm()[i][k], 0);
        }
    return std::pair(moved_mm(world, {0, 0}).z(), moved_mm(world, {14.9, 0}).z());
  };
  // rho g L^2 / (2 M), M = E (1 - nu) / ((1 + nu)(1 - 2 nu)): one dimension, the same everywhere
  const double exact = -1e-6 * 20'000 * 100 / (2 * 20 * 0.7 / (1.3 * 0.4));
  const auto [middle, side] = sunk(SideHold::sliding);
  EXPECT_NEAR(middle, exact, 2e-3 * std::abs(exact));
  EXPECT_NEAR(side, exact, 2e-3 * std::abs(exact));
  const auto [held_middle, held_side] = sunk(SideHold::held);
  EXPECT_NEAR(held_middle, exact, 0.15 * std::abs(exact));  // the sides are three depths apart
  EXPECT_GT(held_side, 0.2 * exact);
  const auto [free_middle, free_side] = sunk(SideHold::free);
  EXPECT_LT(free_side, 1.1 * exact);  // nothing holds it sideways, so it spreads and sinks further
  EXPECT_LT(free_middle, 0.95 * exact);
}

TEST(Loads, OffTheSkinIsRefused) {
  InlineWorkers workers;
  WorldSpec spec = heavy_block();
  spec.loads[1].at = {400, 0};
  EXPECT_THROW(World(spec, workers), InputError);
  spec.loads[1].at = {4, 0}, spec.loads[1].force_N.x() = NAN;
  EXPECT_THROW(World(spec, workers), InputError);
  spec = heavy_block(), spec.gravity_m_s2.z() = INFINITY;
  EXPECT_THROW(World(spec, workers), InputError);
}

}  // namespace test_loads
}  // namespace limberg
