// Regions of a scene: each way to say where one is, what it is made of, and every mistake with its line.
#include <gtest/gtest.h>

#include <fstream>

#include "app/program/temporary_folder.h"
#include "app/scene/scene.h"
#include "sim/base/error.h"

namespace limberg {
namespace test_scene_regions {

const std::string kBlock = R"(name = "t"
[body]
source = "block"
size_mm = [30, 20, 8]
[[layer]]
name = "skin"
thickness_mm = 1.5
young_kPa = 60
poisson = 0.45
[lattice]
cell_mm = 2
)";
const std::string kSoft = "young_kPa = 40\npoisson = 0.45\n";

// A box of 30 x 20 x 9 whose top is of the material "nose" for x < 0; and a tetrahedron.
struct Files {
  TemporaryFolder folder{"regions"};
  Files() {
    write("box.obj",
          "v -15 -10 0\nv 15 -10 0\nv 15 10 0\nv -15 10 0\nv -15 -10 9\nv 15 -10 9\nv 15 10 9\nv -15 10 9\nv 0 -10 9\n"
          "v 0 10 9\nusemtl nose\nf 5 9 10 8\nusemtl rest\nf 9 6 7 10\nf 1 4 3 2\nf 1 2 6 9 5\nf 2 3 7 6\nf 3 4 8 10 "
          "7\nf 4 1 5 8\n");
    write("plate.obj", "v 0 0 0\nv 6 0 0\nv 0 6 0\nv 0 0 6\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    write("open.obj", "v 0 0 0\nv 6 0 0\nv 0 6 0\nv 0 0 6\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder.path() / name) << text; }
  Scene parse(const std::string& text) const { return parse_scene(text, (folder.path() / "t.toml").string()); }
  std::shared_ptr<const Body> body(const std::string& regions, bool obj = false) const {
    std::string text = kBlock;
    if (obj) {
      const size_t a = text.find("source"), b = text.find("[[layer]]");
      text.replace(a, b - a, "source = \"obj\"\nmesh = \"box.obj\"\n");
    }
    return build_body(parse(text + regions));
  }
  /// What is said of these lines, which come after kBlock.
  std::string why(const std::string& regions, bool obj = false) const {
    try {
      body(regions, obj);
    } catch (const InputError& e) {
      return e.what();
    }
    return "nothing";
  }
};

double inside(const Body& body, const Vec3& X, double depth_mm) { return body.regions.at(0)->inside_mm(X, {depth_mm}); }

TEST(SceneRegions, EachWayToSayWhere) {
  const Files f;
  const std::string head = "[[region]]\nname = \"r\"\n" + kSoft;
  const auto plate = f.body(head + "volume = \"plate.obj\"\nscale_to_mm = 0.5\n");
  EXPECT_NEAR(inside(*plate, {0.5, 0.5, 0.5}, 0), 0.5, 1e-9);
  EXPECT_LT(inside(*plate, {2, 2, 2}, 0), 0);
  const auto bundle = f.body(head + "path_mm = [[-5, 0, -3], [5, 0, -3]]\nradius_mm = 2\n");
  EXPECT_NEAR(inside(*bundle, {1, 1, -3}, 3), 1, 1e-9);
  EXPECT_NEAR(inside(*bundle, {8, 0, -3}, 3), -1, 1e-9);
  EXPECT_EQ(*bundle->regions[0]->direction({1, 2, 3}), Vec3::UnitX());
  const auto scar =
      f.body(head + "outline = [[-4, -2], [4, -2], [4, 2], [-4, 2]]\ndepth_mm = [0, 3]\ncolour = [1, 0, 0]\n");
  EXPECT_NEAR(inside(*scar, {3.5, 0, -1}, 1), 0.5, 1e-9);
  EXPECT_NEAR(inside(*scar, {0, 0, -4}, 4), -1, 1e-9);
  EXPECT_EQ(*scar->regions[0]->colour(), Vec3f(1, 0, 0));
  EXPECT_FALSE(scar->regions[0]->direction({0, 0, 0}));
  const auto painted = f.body(head + "paint = \"nose\"\ndepth_mm = [1, 4]\ndirection = [0, 2, 0]\n", true);
  EXPECT_NEAR(inside(*painted, {-7, 0, 6.5}, 2.5), 1.5, 1e-9);
  EXPECT_LT(inside(*painted, {7, 0, 6.5}, 2.5), 0);
  EXPECT_LT(inside(*painted, {-7, 0, 8.5}, 0.5), 0);
  EXPECT_EQ(*painted->regions[0]->direction({0, 0, 0}), Vec3::UnitY());
}

TEST(SceneRegions, AMuscleIsAtRestUnlessItIsSaidToBeActive) {
  const Files f;
  const std::string head =
      "[[region]]\nname = \"r\"\npath_mm = [[0, 0, -3]]\nradius_mm = 2\nlaw = \"muscle\"\nmu_kPa = 5\nk1_kPa = 10\n"
      "k2 = 1\npoisson = 0.45\nactive_kPa = 100\n";
  EXPECT_EQ(f.body(head)->regions[0]->activation(), 0.0);
  EXPECT_EQ(f.body(head + "activation = 0.3\n")->regions[0]->activation(), 0.3);
  EXPECT_FALSE(
      f.body("[[region]]\nname = \"r\"\npath_mm = [[0, 0, -3]]\nradius_mm = 2\n" + kSoft)->regions[0]->activation());
}

TEST(SceneRegions, ItsFileBelongsToTheScene) {
  const Files f;
  const std::string region = "[[region]]\nname = \"r\"\n" + kSoft + "volume = \"plate.obj\"\n";
  const uint64_t hash = f.parse(kBlock + region).hash;
  f.write("plate.obj", "v 0 0 0\nv 7 0 0\nv 0 6 0\nv 0 0 6\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  EXPECT_NE(f.parse(kBlock + region).hash, hash);
}

TEST(SceneRegions, MistakesAreNamed) {
  const Files f;
  const std::string head = "[[region]]\nname = \"r\"\n" + kSoft, ball = "path_mm = [[0, 0, -3]]\nradius_mm = 2\n";
  const auto says = [&](const std::string& text, const std::string& what, bool obj = false) {
    const std::string said = f.why(text, obj);
    EXPECT_NE(said.find(what), std::string::npos) << text << said;
  };
  EXPECT_EQ(f.why(head + ball), "nothing");
  says(head, "t.toml:13: region.name is said to be nowhere; expected one of volume, path_mm, outline, paint");
  says(head + ball + "outline = [[0, 0], [1, 0], [0, 1]]\n", "several places at once");
  says("[[region]]\n" + kSoft + ball, "region.name is missing");
  says(head + ball + head + ball, "is that of another region");
  says("[[region]]\nname = \"r\"\npoisson = 0.4\n" + ball, "region.young_kPa is missing");
  says(head + "path_mm = [[0, 0, -3]]\n", "region.radius_mm is missing");
  says(head + "path_mm = [[0, 0]]\nradius_mm = 1\n", "holds something that is no point");
  says(head + "path_mm = []\nradius_mm = 1\n", "expected a list of 1 to 1000 points [x, y, z]");
  says(head + "path_mm = [[0, 0, -3]]\nradius_mm = 0\n", "expected a number above 0");
  says(head + "outline = [[0, 0], [1, 0]]\n", "expected a list of 3 to 1000 places [x, y]");
  says(head + "outline = [[0, 0], [1, 0], [2, 0]]\n", "holds no area");
  says(head + "outline = [[0, 0], [1, 0], [0, 1]]\ndepth_mm = [3, 2]\n", "is no range; expected [from, to]");
  says(head + "paint = \"nose\"\n", "the body is a block");
  says(head + "paint = \"ear\"\n", "t.toml:12: region 'r' is painted 'ear', and no face", true);
  says(head + "volume = \"none.obj\"\n", "none.obj");
  says(head + "volume = \"open.obj\"\n", "the region is open at an edge");
  says(head + ball + "colour = [1, 2, 0]\n", "region.colour");
  says(head + ball + "thickness_mm = 3\n", "unknown key \"thickness_mm\"");
  says(head + ball + "depth_mm = [0, 2]\n", "unknown key \"depth_mm\"");
}

}  // namespace test_scene_regions
}  // namespace limberg
