// Skin with fibres under the knife: what their direction must do.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "app/assembly/operation.h"
#include "app/program/places.h"
#include "app/scene/scene.h"
#include "app/study/wound.h"
#include "sim/commands/script.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {
namespace test_fibre_scenes {

/// `stretch`: the same prestretch along and across, so that only the fibres tell the directions apart.
std::string scene_text(double angle_deg, double stretch, const char* law) {
  const double a = angle_deg * std::numbers::pi / 180;
  std::ostringstream s;
  s << "[body]\nsource = \"block\"\nsize_mm = [70, 70, 8]\nskin_cell_mm = 2\ntension_direction = [" << std::cos(a)
    << ", " << std::sin(a) << ", 0]\n"
    << "[[layer]]\nname = \"skin\"\nthickness_mm = 1.5\n"
    << law << "poisson = 0.47\nprestretch_along = " << stretch << "\nprestretch_across = " << stretch
    << "\n[[layer]]\nname = \"fat\"\nthickness_mm = 6.5\nyoung_kPa = 6\npoisson = 0.47\n[lattice]\ncell_mm = 4\n";
  return s.str();
}
constexpr const char* kFibres =
    "law = \"gasser-ogden-holzapfel\"\nmu_kPa = 15\nk1_kPa = 100\nk2 = 2\nkappa = 0.1\nfibre_angle_deg = 0\n";
constexpr const char* kPlain = "young_kPa = 60\n";

StepReport settle(World& w, int iterations = 600) {
  StepSettings s;
  s.max_iterations = iterations, s.tolerance = 1e-5;
  return w.step(s);
}

double gape(double angle_deg, const char* law) {
  const Scene scene = parse_scene(scene_text(angle_deg, 1.08, law), "s.toml");
  InlineWorkers workers;
  World world(world_spec(scene, build_body(scene)), workers);
  EXPECT_TRUE(world.apply(Incise{{{-15, 0}, {15, 0}}, 4}).done);
  EXPECT_LE(settle(world).residual, 2e-5);
  Snapshot s;
  world.fill(s);
  return study::StraightWound(s).gape_mm(0);
}

// A wound across the fibres gapes, one along them hardly more
// than in plain skin; in plain skin the direction means nothing.
TEST(FibreScenes, AWoundOpensByItsAngleToTheTensionLines) {
  const double along = gape(0, kFibres), between = gape(45, kFibres), across = gape(90, kFibres);
  EXPECT_GT(along, 0.05);
  // What must hold is the order; the margin is what the lattice may do of itself (below).
  EXPECT_GT(between, along * 1.02);
  EXPECT_GT(across, between * 1.02);
  const double a = gape(0, kPlain), b = gape(90, kPlain);
  EXPECT_NEAR(a, b, 0.02 * a);  // the lattice is square, so 0 and 90 degrees see the same cells
}

/// Force of a hook that pulls the skin by 8 mm in the plane, at an angle to the tension lines.
double pull(double angle_deg, const char* law) {
  const Scene scene = parse_scene(scene_text(0, 1.0, law), "s.toml");
  InlineWorkers workers;
  World world(world_spec(scene, build_body(scene)), workers);
  EXPECT_TRUE(world.apply(SetHook{1, {0, 0}}).done);
  const double a = angle_deg * std::numbers::pi / 180;
  for (int k = 1; k <= 4; ++k) {
    EXPECT_TRUE(world.apply(MoveHook{1, {2 * k * std::cos(a), 2 * k * std::sin(a), 0}, 0}).done);
    settle(world, 200);
  }
  EXPECT_LE(settle(world).residual, 2e-5);
  Snapshot s;
  world.fill(s);
  return double(s.hooks.at(0).force_N.norm());
}

TEST(FibreScenes, TheSkinPullsHarderAlongItsFibres) {
  const double along = pull(0, kFibres), across = pull(90, kFibres);
  EXPECT_GT(along, 1.1 * across);
  const double a = pull(0, kPlain), b = pull(90, kPlain);
  EXPECT_NEAR(a, b, 0.01 * a);
}

// The shipped flap in fibrous skin of the library, every action of the script, to rest.
TEST(FibreScenes, TheRhomboidFlapGoesToItsEnd) {
  Scene scene = load_scene(source_dir() + "/app/scenes/cheek.toml");
  scene.cell_mm = 5;
  scene.block.skin_cell_mm = 2;
  InlineWorkers workers;
  World world(world_spec(scene, build_body(scene)), workers);
  std::ifstream in(source_dir() + "/recordings/rhomboid.jsonl");
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  OperationSettings s;
  s.rest_steps = 12, s.final_steps = 150, s.rest_residual = 1e-4;
  const OperationOutcome end = operate(world, scene.tools.max_depth_mm, parse_script(text, "rhomboid.jsonl"), s);
  EXPECT_LE(end.last.residual, 1e-5);
  EXPECT_GT(end.last.min_J, 0.2);
  EXPECT_EQ(world.skin()->pieces(), 1);
  EXPECT_NEAR(world.skin()->volume_mm3() + world.skin()->removed_volume_mm3(), world.skin()->initial_volume_mm3(),
              1e-6 * world.skin()->initial_volume_mm3());
}

}  // namespace test_fibre_scenes
}  // namespace limberg
