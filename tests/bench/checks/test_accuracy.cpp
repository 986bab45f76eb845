// Error against run time on a small scene, and what is made of it.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "app/operating_point/accuracy.h"
#include "app/operating_point/accuracy_probe.h"
#include "app/operating_point/operating_point.h"
#include "app/program/places.h"
#include "sim/base/error.h"
#include "sim/testing/reference_newton.h"
#include "tests/sim/fem/models.h"

namespace limberg {
namespace test_accuracy {

const char* const kSmall = R"(name = "small"
[body]
source = "block"
size_mm = [30, 30, 8]
skin_cell_mm = 2
[[layer]]
name = "skin"
thickness_mm = 2
young_kPa = 60
poisson = 0.45
density_kg_m3 = 1100
prestretch_along = 1.05
[[layer]]
name = "fat"
thickness_mm = 6
young_kPa = 15
poisson = 0.45
density_kg_m3 = 920
[lattice]
cell_mm = 5       # coarse
[camera]
fov_deg = 26
)";

TEST(Accuracy, ASmallSceneGivesAFrontAndAPoint) {
  const Scene scene = parse_scene(std::string(kSmall) + "[build]\ncan_cut = false\n", "small.toml");
  bench::AccuracySettings s;
  s.quick = true, s.budget_ms = 1000;
  const bench::AccuracyReport r = bench::accuracy(scene, s);
  ASSERT_GE(r.trials.size(), 12u);
  EXPECT_EQ(r.left_out, 0u);
  int chosen = 0, front = 0;
  for (const auto& t : r.trials) {
    EXPECT_GT(t.frame_ms, 0);
    EXPECT_GT(t.error_mm, 0);
    EXPECT_LE(t.error_mm, 1.001 * (t.lattice_mm + t.behind_mm));  // the triangle inequality of root mean squares
    chosen += t.chosen, front += t.pareto;
    for (const auto& o : r.trials) EXPECT_FALSE(t.pareto && o.frame_ms < t.frame_ms && o.error_mm < t.error_mm);
    for (const auto& o : r.trials)
      if (t.chosen) {
        EXPECT_LE(t.error_mm, 1.05 * o.error_mm);
      }  // all fit such a budget
  }
  EXPECT_EQ(chosen, 1);
  EXPECT_GT(front, 0);
  EXPECT_TRUE(r.point.fits);
  EXPECT_NE(r.svg().find("Pareto front"), std::string::npos);
  const std::string csv = r.csv();
  EXPECT_EQ(size_t(std::count(csv.begin(), csv.end(), '\n')), r.trials.size() + 1);
}

// All elements see the same even deformation with the same energy: layers and prestretch are carried over. Only ours
// lets layers that share a cell slide; that is left out here.
TEST(Accuracy, OtherElementsAreOfTheSameMaterial) {
  const Scene scene = parse_scene(kSmall, "small.toml");
  InlineWorkers workers;
  const bench::Probe p = bench::make_probe(scene, build_body(scene), 5, workers);
  Mat3 A;
  A << 1.1, 0.1, 0, 0.05, 0.95, 0.1, 0, 0.1, 1.05;
  const auto energy = [&](const FemModel& m) {
    std::vector<Vec3> u;
    for (const Vec3& X : m.X_mm) u.push_back((A - Mat3::Identity()) * X);
    return ReferenceElasticity(m, {}).energy(u);
  };
  FemModel bonded = *p.model;
  for (Stencil& s : bonded.stencils) s.slide_kPa = 0;
  const double scenes = energy(bonded);
  for (auto make : {bench::with_full_integration, bench::with_tetrahedra}) {
    const auto m = make(bonded);
    ASSERT_TRUE(m);
    EXPECT_NEAR(energy(*m), scenes, 1e-6 * std::fabs(scenes));
    EXPECT_TRUE(std::isfinite(energy(*make(*p.model))));
  }
}

TEST(OperatingPoint, ChangesTheScenesTextInTwoPlaces) {
  const Scene scene = parse_scene(kSmall, "small.toml"), other = at_operating_point(scene, 3.25, 7),
              again = at_operating_point(other, 4, 9);
  EXPECT_EQ(other.cell_mm, 3.25);
  EXPECT_EQ(other.iterations_per_step, 7);
  EXPECT_NE(other.hash, scene.hash);
  EXPECT_EQ(again.cell_mm, 4);
  EXPECT_EQ(again.iterations_per_step, 9);
  EXPECT_EQ(parse_scene(other.text, "small.toml").hash, other.hash);
  EXPECT_EQ(other.block.size_mm, scene.block.size_mm);
}

// However a file writes the two values: under a heading, dotted, inline or not at all.
TEST(OperatingPoint, ChangesAnySceneThatCanBeWritten) {
  std::string small = kSmall;
  const std::string lattice = "[lattice]\ncell_mm = 5       # coarse\n";
  ASSERT_NE(small.find(lattice), std::string::npos);
  small.erase(small.find(lattice), lattice.size());
  for (const std::string& text :
       {"lattice.cell_mm = 5.0\nsolver.iterations_per_step = 3\nlattice.region_mm = 30.0\n" + small,
        "lattice = { cell_mm = 5.0, region_mm = 30.0 }\n" + small,
        "# [lattice]\n" + small + "[lattice] # cell_mm = 1\n\"cell_mm\"=5.0\nregion_mm = 30.0\n",
        small + "[lattice]\nregion_mm = 30.0\n"}) {
    const Scene other = at_operating_point(parse_scene(text, "any.toml"), 3.25, 7);
    EXPECT_EQ(other.cell_mm, 3.25) << text;
    EXPECT_EQ(other.iterations_per_step, 7) << text;
    EXPECT_EQ(other.region_mm, 30) << text;
    EXPECT_EQ(parse_scene(other.text, "any.toml").hash, other.hash) << text;
  }
  for (const char* name : {"rhomboid", "zplasty", "cheek", "scalp"}) {
    const Scene shipped = load_scene(source_dir() + "/app/scenes/" + name + ".toml");
    const Scene other = at_operating_point(shipped, shipped.cell_mm, shipped.iterations_per_step);
    EXPECT_EQ(other.note, shipped.note);
    EXPECT_EQ(other.steps_per_s, shipped.steps_per_s);
    EXPECT_EQ(other.block.size_mm, shipped.block.size_mm);
    EXPECT_EQ(other.camera.eye_mm(), shipped.camera.eye_mm());
    EXPECT_EQ(other.landmarks.size(), shipped.landmarks.size());
    ASSERT_EQ(other.layers().size(), shipped.layers().size());
    for (size_t i = 0; i < other.layers().size(); ++i) {
      EXPECT_EQ(other.layers()[i].name, shipped.layers()[i].name);
      EXPECT_EQ(other.layers()[i].thickness_mm, shipped.layers()[i].thickness_mm);
    }
  }
}

// Small cells stay the parts of the large ones that they were.
TEST(OperatingPoint, TakesFineCellsAlong) {
  std::string text = kSmall;
  text.insert(text.find("[camera]"), "wound_cell_mm = 2.5\nfine = [{at_mm = [0, 0], radius_mm = 4, cell_mm = 1.25}]\n");
  for (const double cell_mm : {2.87143, 3.0, 7.7}) {
    const Scene other = at_operating_point(parse_scene(text, "small.toml"), cell_mm, 7);
    EXPECT_EQ(other.wound_level, 1);
    ASSERT_EQ(other.fine.size(), 1u);
    EXPECT_EQ(other.fine[0].level, 2);
  }
}

TEST(OperatingPoint, IsReadBackAndBelongsToItsScene) {
  const Scene scene = parse_scene(kSmall, "small.toml"), other = at_operating_point(scene, 3, 7);
  const std::string file = (std::filesystem::temp_directory_path() / "limberg-point.json").string();
  bench::OperatingPoint p;
  p.cell_mm = 4.5, p.iterations = 12, p.frame_ms = 3, p.error_mm = 0.2, p.budget_ms = 8, p.scene_hash = scene.hash;
  Result r("bench", scene.name);
  fill_operating_point(r, p);
  r.write(file);
  const bench::OperatingPoint q = read_operating_point(file, scene);
  EXPECT_EQ(q.cell_mm, 4.5);
  EXPECT_EQ(q.iterations, 12);
  EXPECT_THROW(read_operating_point(file, other), InputError);
  std::ofstream(file) << "{\"operating_point\": {\"cell_mm\": -1}}";
  EXPECT_THROW(read_operating_point(file, scene), InputError);
  std::ofstream(file) << "[1, 2";
  EXPECT_THROW(read_operating_point(file, scene), InputError);
  std::filesystem::remove(file);
  EXPECT_THROW(read_operating_point(file, scene), InputError);
}

}  // namespace test_accuracy
}  // namespace limberg
