// A region of interest: what lies outside holds still and is no work; what lies inside is as if its rim were held.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/body/block.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"

namespace limberg {
namespace test_region {

WorldSpec block(double region_mm) {
  BlockSpec b;
  b.size_mm = {80, 80, 8};
  b.skin_cell_mm = 2;
  Material skin, fat;
  skin.young_kPa = 60, skin.poisson = 0.45, skin.prestretch_along = skin.prestretch_across = 1.05;
  fat.young_kPa = 12, fat.poisson = 0.45, fat.prestretch_along = fat.prestretch_across = 1.04;
  b.layers = {{"skin", 1.5, skin}, {"fat", 6.5, fat}};
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = 4;
  spec.region_mm = region_mm;
  return spec;
}

StepReport pull(World& world) {
  EXPECT_TRUE(world.apply(Incise{{{-10, 0}, {10, 0}}, 4, 90, false}).done);
  EXPECT_TRUE(world.apply(SetHook{1, {0, 3}}).done);
  EXPECT_TRUE(world.apply(MoveHook{1, {0, 6, 4}, 0}).done);
  StepSettings s;
  s.max_iterations = 20, s.tolerance = 1e-5;
  StepReport r;
  for (int k = 0; k < 100 && !(r.converged && !r.preconditioner_pending); ++k) r = world.step(s);
  return r;
}

TEST(Region, OutsideHoldsStillAndInsideMovesAsBefore) {
  InlineWorkers workers;
  World whole(block(0), workers), part(block(25), workers);
  EXPECT_TRUE(pull(whole).converged);
  const StepReport r = pull(part);
  EXPECT_TRUE(r.converged);
  EXPECT_EQ(r.inverted_cells, 0);
  const FemModel &m = part.skin()->solver().model(), &w = whole.skin()->solver().model();
  ASSERT_EQ(m.X_mm.size(), w.X_mm.size());
  EXPECT_NE(part.skin()->solver().describe().find("region of"), std::string::npos)
      << "the solver knows nothing of the rest";
  EXPECT_EQ(whole.skin()->solver().describe().find("region of"), std::string::npos);
  size_t absent = 0, still = 0;
  for (const HexCell& c : m.cells) absent += c.scale == 0;
  EXPECT_GT(absent, m.cells.size() / 2);
  double largest = 0, difference = 0;
  for (size_t i = 0; i < m.X_mm.size(); ++i) {
    const Vec3f u = part.skin()->solver().displacement_mm()[i], v = whole.skin()->solver().displacement_mm()[i];
    const double away = m.X_mm[i].head<2>().norm();
    if (away > 25) {
      EXPECT_EQ(u.norm(), 0);
      ++still;
    }
    largest = std::max(largest, double(v.norm()));
    if (away < 12) difference = std::max(difference, double((u - v).norm()));
  }
  EXPECT_GT(still, m.X_mm.size() / 2);
  EXPECT_GT(largest, 1);
  EXPECT_LT(difference, 0.05 * largest);  // the rim is two wounds' lengths away
  // The patient's forces still balance: hooks and supports.
  Snapshot s;
  part.fill(s);
  ASSERT_EQ(s.hooks.size(), 1u);
  const Vec3 hook = s.hooks[0].force_N.cast<double>(), support = part.skin()->solver().support_force_mN() / 1000;
  EXPECT_LT((support - hook).norm(), 0.01 * hook.norm()) << "what the held nodes receive is what the hook gives";
}

TEST(Region, UndoBringsItBack) {
  InlineWorkers workers;
  World world(block(25), workers);
  StepSettings s;
  s.tolerance = 1e-5;
  for (int k = 0; k < 5; ++k) world.step(s);
  const uint64_t before = world.topology_hash();
  ASSERT_TRUE(world.apply(Incise{{{-10, 0}, {10, 0}}, 4, 90, false}).done);
  world.step(s);
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.topology_hash(), before);
  world.step(s);
}

}  // namespace test_region
}  // namespace limberg
