// The scene of lids at rest: they stay before the globe, and no cell is near to turning inside out.
#include <gtest/gtest.h>

#include <algorithm>

#include "app/program/places.h"
#include "app/scene/scene.h"
#include "app/session/workers_pool.h"
#include "sim/imaging/anatomical/eye_shape.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"

namespace limberg {
namespace test_lids {

// Pre-tension opens free margins a little. Nothing pushes before the first cut: the lids must stay off the globe by
// themselves.
TEST(Lids, LieBeforeTheGlobeAtRest) {
  using anatomical::Eye;
  const Scene scene = load_scene(source_dir() + "/app/scenes/lids.toml");
  const auto body = build_body(scene);
  WorkersPool workers(2);
  World world(world_spec(scene, body), workers);
  StepSettings steps;
  steps.max_iterations = 600, steps.tolerance = 1e-5;
  const StepReport rest = world.step(steps);
  EXPECT_TRUE(rest.converged);
  EXPECT_EQ(rest.inverted_cells, 0);
  EXPECT_GT(rest.min_J, 0.9);
  Snapshot s;
  world.fill(s);
  double deepest = 1e3, moved = 0;
  for (size_t v = 0; v < s.x_mm.size(); ++v) {
    const Vec3 x = s.x_mm[v].cast<double>();
    deepest = std::min(deepest, Eye::globe_mm(x));
    moved = std::max(moved, (x - s.topology->view.X_mm[v]).norm());
  }
  EXPECT_GT(deepest, -0.3);  // what may lie in the globe
  EXPECT_GT(moved, 0.01) << "pre-tension that moves nothing is none";
  EXPECT_LT(moved, 1);
}

}  // namespace test_lids
}  // namespace limberg
