// What holds softly: springs by area, to where the tissue lies at rest.
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/lattice/sheet_bodies.h"

namespace limberg {
namespace test_soft_hold {

constexpr double kSize_mm = 40, kHigh_mm = 12, kSoft_kPa_mm = 0.5;

/// A slab on springs, held by nothing else.
std::shared_ptr<const Body> on_springs(double kPa_mm = kSoft_kPa_mm) {
  test::Sheet sheet;
  sheet.size_mm = kSize_mm, sheet.cells = 16, sheet.below = SurfaceTag::free;
  sheet.top = [](double, double) { return 0.0; };
  sheet.bottom = [](double, double) { return -kHigh_mm; };
  auto b = std::make_shared<Body>(test::layered(test::sheet_mesh(sheet), 1.5));
  for (const Tri& t : b->surface.tri) {
    const bool below =
        std::all_of(t.begin(), t.end(), [&](int32_t v) { return b->surface.X_mm[size_t(v)].z() < -kHigh_mm + 0.01; });
    b->soft_kPa_mm.push_back(below ? float(kPa_mm) : 0);
  }
  return b;
}

StepReport to_rest(World& world) {
  StepSettings s;
  s.max_iterations = 50, s.tolerance = 1e-6;
  StepReport r;
  for (int k = 0; k < 200 && !(r.converged && !r.preconditioner_pending && world.settled()); ++k) r = world.step(s);
  return r;
}

std::unique_ptr<World> world_of(std::shared_ptr<const Body> body, const Vec3& gravity, double cell_mm,
                                Workers& workers) {
  WorldSpec spec;
  spec.body = std::move(body), spec.cell_mm = cell_mm, spec.gravity_m_s2 = gravity;
  return std::make_unique<World>(spec, workers);
}

/// Mean move of what lies on the springs.
Vec3 bottom_mm(const World& world) {
  Snapshot s;
  world.fill(s);
  Vec3 sum = Vec3::Zero();
  double n = 0;
  for (size_t v = 0; v < s.x_mm.size(); ++v)
    if (const Vec3& X = s.topology->view.X_mm[v]; X.z() < -kHigh_mm + 0.01) sum += s.x_mm[v].cast<double>() - X, ++n;
  return sum / n;
}

// Weight over stiffness, whatever the cells: rho g h / k.
TEST(SoftHold, ASlabSinksByItsWeight) {
  InlineWorkers workers;
  for (const double cell : {5.0, 3.5}) {
    const auto world = world_of(on_springs(), {0, 0, -9.81}, cell, workers);
    EXPECT_LT(to_rest(*world).residual, 1e-5);
    const double weight_mN = world->skin()->volume_mm3() * 1e-6 * 9810, area = kSize_mm * kSize_mm;
    EXPECT_NEAR(bottom_mm(*world).z(), -weight_mN / (kSoft_kPa_mm * area), 0.02 * weight_mN / (kSoft_kPa_mm * area))
        << cell;
    EXPECT_NEAR(world->skin()->soft_hold_force_mN().z(), weight_mN, 0.01 * weight_mN) << cell;
  }
}

TEST(SoftHold, WithoutALoadNothingMoves) {
  InlineWorkers workers;
  const auto world = world_of(on_springs(), Vec3::Zero(), 5, workers);
  to_rest(*world);
  EXPECT_LT(bottom_mm(*world).norm(), 1e-4);
}

// Twice as stiff sinks half as far, and far stiffer than the tissue is hardly at all: it gives between the springs.
TEST(SoftHold, StiffSpringsHold) {
  InlineWorkers workers;
  const auto sunk = [&](double kPa_mm) {
    const auto world = world_of(on_springs(kPa_mm), {0, 0, -9.81}, 5, workers);
    EXPECT_LT(to_rest(*world).residual, 1e-5) << kPa_mm;
    return -bottom_mm(*world).z();
  };
  const double soft = sunk(0.5);
  EXPECT_NEAR(sunk(1), soft / 2, 0.02 * soft);
  EXPECT_LT(sunk(500), 1e-2 * soft);
}

// Cut through from top to bottom, both banks lie on what is below them; undo brings back the state to the bit.
TEST(SoftHold, PartsOfACutKeepTheirOwn) {
  InlineWorkers workers;
  const auto world = world_of(on_springs(), {0, 0, -9.81}, 5, workers);
  to_rest(*world);
  const double before = bottom_mm(*world).z(), force = world->skin()->soft_hold_force_mN().z();
  const uint64_t hash = world->state_hash();
  Incise cut;
  cut.path = {{-15, 3.1}, {15, 3.1}}, cut.depth_mm = 20;
  const Outcome made = world->apply(cut);
  ASSERT_TRUE(made.done) << made.reason;
  to_rest(*world);
  EXPECT_NEAR(bottom_mm(*world).z(), before, 0.02 * std::abs(before));
  EXPECT_NEAR(world->skin()->soft_hold_force_mN().z(), force, 0.01 * force);
  ASSERT_TRUE(world->apply(Undo{}).done);
  EXPECT_EQ(world->state_hash(), hash);
}

}  // namespace test_soft_hold
}  // namespace limberg
