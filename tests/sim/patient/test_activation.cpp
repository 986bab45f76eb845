// A muscle in a patient: it shortens by what its law says, rests again, and goes back and forth with undo.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/body/block.h"
#include "sim/fem/materials/catalogue.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/lattice/sheet_bodies.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_activation {

constexpr double kTension_kPa = 20, kMu_kPa = 5, kNu = 0.45;

Material muscle(double activation = 0) {
  Material m;
  m.poisson = kNu, m.young_kPa = 2 * (1 + kNu) * kMu_kPa;
  m.law = {"muscle",
           {{"mu_kPa", {kMu_kPa}},
            {"k1_kPa", {10}},
            {"k2", {1}},
            {"active_kPa", {kTension_kPa}},
            {"activation", {activation}}}};
  return m;
}

void to_rest(World& world) {
  StepSettings s;
  s.max_iterations = 20, s.tolerance = 1e-5;
  StepReport r;
  for (int k = 0; k < 400 && !(r.converged && !r.preconditioner_pending && world.settled()); ++k) r = world.step(s);
  EXPECT_TRUE(r.converged);
}

double most_along_x_mm(const World& world) {
  Snapshot s;
  world.fill(s);
  double most = -1e9;
  for (const Vec3f& x : s.x_mm) most = std::max(most, double(x.x()));
  return most;
}

/// Symmetry planes on three sides, the others free: what is in it is the same everywhere.
WorldSpec bar() {
  BlockSpec b;
  b.size_mm = {30, 12, 12}, b.skin_cell_mm = 2;
  b.sides = {SideHold::sliding, SideHold::free, SideHold::sliding, SideHold::free, SideHold::sliding};
  Body body = make_block(b);
  RegionSpec all;
  all.name = "bar", all.material = muscle();
  all.outline_mm = {{-50, -50}, {50, -50}, {50, 50}, {-50, 50}};
  body.regions.push_back(std::make_shared<Region>(all, body));
  WorldSpec spec;
  spec.body = std::make_shared<Body>(std::move(body));
  spec.cell_mm = 3;
  return spec;
}

/// Where dW/d(along) and dW/d(across) vanish: W = mu/2 (a^2 + 2 c^2) - mu (J - 1) + lambda/2 (J - 1)^2 + the pull,
/// whose slope is activation T (1 - ((a - 1)/.56)^2); passive fibres do not push.
double shortened(double activation) {
  const double lambda = layer_response(muscle()).lambda_kPa;
  const auto slope_across = [&](double a, double c) {
    return 2 * kMu_kPa * c + 2 * a * c * (lambda * (a * c * c - 1) - kMu_kPa);
  };
  const auto across = [&](double a) {
    double lo = 0.5, hi = 2;
    for (int k = 0; k < 100; ++k) {
      const double m = 0.5 * (lo + hi);
      (slope_across(a, m) > 0 ? hi : lo) = m;
    }
    return lo;
  };
  double lo = 0.5, hi = 1;
  for (int k = 0; k < 100; ++k) {
    const double a = 0.5 * (lo + hi), c = across(a), x = (a - 1) / 0.56;
    const double slope =
        kMu_kPa * a + c * c * (lambda * (a * c * c - 1) - kMu_kPa) + activation * kTension_kPa * (1 - x * x);
    (slope > 0 ? hi : lo) = a;
  }
  return lo;
}

TEST(Activation, ABarShortensByWhatItsLawSays) {
  InlineWorkers workers;
  World world(bar(), workers);
  to_rest(world);
  EXPECT_NEAR(most_along_x_mm(world), 15, 1e-3);
  for (const double level : {0.2, 0.6, 1.0}) {
    ASSERT_TRUE(world.apply(Activate{"bar", level}).done);
    to_rest(world);
    const double length = 30 * shortened(level);
    EXPECT_LT(length, 30 - 5 * level);  // it is no small strain
    EXPECT_NEAR(most_along_x_mm(world) + 15, length, 2e-3 * 30) << level;
  }
  ASSERT_TRUE(world.apply(Activate{"bar", 0}).done);
  to_rest(world);
  EXPECT_NEAR(most_along_x_mm(world), 15, 2e-3);
}

// What carries no tension is at rest, however stiff it is and however it lies in the cells.
TEST(Regions, AStiffPlateInACurvedBodyMovesNothing) {
  test::Sheet sheet;
  sheet.size_mm = 40, sheet.cells = 20;
  sheet.top = [](double x, double y) { return 16 - (x * x + y * y) / 60; };
  sheet.bottom = [](double x, double y) { return 6 - (x * x + y * y) / 60; };
  Body body = test::layered(test::sheet_mesh(sheet), 1.5);
  RegionSpec plate;
  plate.name = "plate", plate.material.young_kPa = 3000, plate.material.poisson = 0.45;
  plate.outline_mm = {{-9, -7}, {8, -6}, {7, 9}, {-6, 8}}, plate.from_mm = 1.2, plate.to_mm = 2.4;
  body.regions.push_back(std::make_shared<Region>(plate, body));
  WorldSpec spec;
  spec.body = std::make_shared<Body>(std::move(body));
  spec.cell_mm = 4;
  InlineWorkers workers;
  World world(spec, workers);
  to_rest(world);
  Snapshot s;
  world.fill(s);
  double moved = 0;
  for (size_t v = 0; v < s.x_mm.size(); ++v)
    moved = std::max(moved, (s.x_mm[v].cast<double>() - s.topology->view.X_mm[v]).norm());
  EXPECT_LT(moved, 0.02);  // by the sliding of skin on fat alone, without the plate, 0.004
}

WorldSpec with_bundle(double activation = 0) {
  WorldSpec spec = test::small_block();
  auto body = std::make_shared<Body>(*spec.body);
  RegionSpec bundle;
  bundle.name = "bundle", bundle.material = muscle(activation);
  bundle.path_mm = {{-15, 0, -5}, {15, 0, -5}}, bundle.radius_mm = 3;
  body->regions.push_back(std::make_shared<Region>(bundle, *body));
  RegionSpec scar;
  scar.name = "scar", scar.material.young_kPa = 200;
  scar.outline_mm = {{-5, 10}, {5, 10}, {5, 15}, {-5, 15}}, scar.to_mm = 2;
  body->regions.push_back(std::make_shared<Region>(scar, *body));
  spec.body = body;
  return spec;
}

TEST(Activation, UndoAndRedoGoBackAndForth) {
  InlineWorkers workers;
  World world(with_bundle(), workers);
  to_rest(world);
  const uint64_t rest = world.full_hash();
  ASSERT_TRUE(world.apply(Activate{"bundle", 0.7}).done);
  EXPECT_NE(world.full_hash(), rest);
  to_rest(world);
  const uint64_t pulled = world.full_hash();
  const Outcome cut = world.apply(Incise{{{-10, 5}, {10, 5}}, 4});
  ASSERT_TRUE(cut.done) << cut.reason;
  to_rest(world);
  const uint64_t opened = world.full_hash();
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.full_hash(), pulled);
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.full_hash(), rest);
  ASSERT_TRUE(world.apply(Redo{}).done);
  EXPECT_EQ(world.full_hash(), pulled);
  ASSERT_TRUE(world.apply(Redo{}).done);
  EXPECT_EQ(world.full_hash(), opened);
  // The cut tissue is as active as it was before the cut.
  EXPECT_EQ(world.skin()->solver().model().laws.size(), 1u);
}

// A scene that begins with an active muscle, and one that is told to be.
TEST(Activation, AtFirstIsAsToldLater) {
  InlineWorkers workers;
  World begins(with_bundle(0.5), workers), told(with_bundle(), workers);
  ASSERT_TRUE(told.apply(Activate{"bundle", 0.5}).done);
  to_rest(begins), to_rest(told);
  Snapshot a, b;
  begins.fill(a), told.fill(b);
  double apart = 0, moved = 0;
  for (size_t v = 0; v < a.x_mm.size(); ++v) {
    apart = std::max(apart, double((a.x_mm[v] - b.x_mm[v]).norm()));
    moved = std::max(moved, (a.x_mm[v].cast<double>() - a.topology->view.X_mm[v]).norm());
  }
  EXPECT_GT(moved, 0.3);
  EXPECT_LT(apart, 1e-3);
}

TEST(Activation, WhatIsNoMuscleIsRefused) {
  InlineWorkers workers;
  World world(with_bundle(), workers);
  const uint64_t before = world.full_hash();
  for (const char* name : {"scar", "nobody", ""}) {
    const Outcome o = world.apply(Activate{name, 0.5});
    EXPECT_FALSE(o.done);
    EXPECT_NE(o.reason.find("expected one of bundle"), std::string::npos) << o.reason;
  }
  EXPECT_EQ(world.full_hash(), before);
  World plain(test::small_block(), workers);
  EXPECT_NE(plain.apply(Activate{"bundle", 0.5}).reason.find("[[region]]"), std::string::npos);
}

}  // namespace test_activation
}  // namespace limberg
