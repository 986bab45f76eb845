// Layers of a scene that are not as thick everywhere: each way to say so, its file in the hash and in a recording, and
// every mistake with its line.
#include <gtest/gtest.h>

#include <fstream>

#include "app/assembly/bundle.h"
#include "app/program/temporary_folder.h"
#include "app/scene/scene.h"
#include "calibration/calibration.h"
#include "sim/base/error.h"

namespace limberg {
namespace test_scene_thickness {

struct Files {
  TemporaryFolder folder{"thickness"};
  Files() {
    write("skin.txt", "# x y z thickness\n0 0 0 2.5\n");
    write("bed.obj", "v -40 -40 -3\nv 40 -40 -3\nv 40 40 -3\nv -40 40 -3\nf 1 2 3 4\n");
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder.path() / name) << text; }
  Scene parse(const std::string& skin, const std::string& fat = "") const {
    const std::string text =
        "name = \"t\"\n[body]\nsource = \"block\"\nsize_mm = [30, 20, 8]\n[lattice]\ncell_mm = 2\n[[layer]]\nname = "
        "\"skin\"\nthickness_mm = 1.5\nyoung_kPa = 60\npoisson = 0.45\n" +
        skin + "[[layer]]\nname = \"fat\"\nthickness_mm = 10\nyoung_kPa = 15\npoisson = 0.45\n" + fat;
    return parse_scene(text, (folder.path() / "t.toml").string());
  }
  std::string why(const std::string& skin, const std::string& fat = "") const {
    try {
      build_body(parse(skin, fat));
    } catch (const InputError& e) {
      return e.what();
    }
    return "nothing";
  }
};

TEST(SceneThickness, EachWayToSayIt) {
  const Files f;
  const auto at_origin = [&](const std::string& skin) {
    const auto body = build_body(f.parse(skin));
    size_t best = 0;
    for (size_t v = 0; v < body->surface.X_mm.size(); ++v)
      if (body->surface.X_mm[v].norm() < body->surface.X_mm[best].norm()) best = v;
    return body->layer_thickness_mm(0, int32_t(best));
  };
  EXPECT_NEAR(at_origin(""), 1.5, 1e-6);
  EXPECT_NEAR(at_origin("thickness_points = [[0, 0, 0, 2]]\n"), 2, 1e-6);
  EXPECT_NEAR(at_origin("thickness_file = \"skin.txt\"\n"), 2.5, 1e-6);
  EXPECT_NEAR(at_origin("down_to = \"bed.obj\"\n"), 3, 1e-6);
  EXPECT_NEAR(at_origin("down_to = \"bed.obj\"\nscale_to_mm = 2\n"), 6, 1e-6);
}

TEST(SceneThickness, ItsFilesBelongToTheSceneAndToItsRecording) {
  const Files f;
  for (const std::string name : {"skin.txt", "bed.obj"}) {
    const std::string skin = (name == "skin.txt" ? "thickness_file = \"" : "down_to = \"") + name + "\"\n";
    const Scene scene = f.parse(skin);
    Recording rec;
    rec.blobs = bundle(scene, Calibration());
    const Unbundled again = unbundle_scene(rec, "t.lcm");
    EXPECT_EQ(again.scene.hash, scene.hash);
    EXPECT_EQ(build_body(again.scene)->thickness_mm, build_body(scene)->thickness_mm);
    f.write(name, name == "skin.txt" ? "0 0 0 2.6\n" : "v -40 -40 -4\nv 40 -40 -4\nv 40 40 -4\nf 1 2 3\n");
    EXPECT_NE(f.parse(skin).hash, scene.hash);
  }
}

TEST(SceneThickness, MistakesAreNamed) {
  const Files f;
  const auto says = [&](const std::string& skin, const std::string& what, const std::string& fat = "") {
    const std::string said = f.why(skin, fat);
    EXPECT_NE(said.find(what), std::string::npos) << skin << fat << said;
  };
  says("thickness_points = []\n", "t.toml:12: layer.thickness_points is no such list; expected a list of 1 to 1000");
  says("thickness_points = [[0, 0, 2]]\n", "holds something that is no place");
  says("thickness_points = [[0, 0, 0, 0]]\n", "holds a thickness of 0 mm");
  says("thickness_points = [[0, 0, 0, 2]]\nthickness_file = \"skin.txt\"\n", "is given beside another thickness");
  says("thickness_file = \"skin.txt\"\ndown_to = \"bed.obj\"\n", "is given beside another thickness");
  says("thickness_file = \"none.txt\"\n", "none.txt");
  says("down_to = \"none.obj\"\n", "none.obj");
  says("scale_to_mm = 2\n", "unknown key \"scale_to_mm\"");
  says("", "reaches down to the bottom", "thickness_file = \"skin.txt\"\n");
  f.write("skin.txt", "0 0 0 2\n0 0 0\n");
  says("thickness_file = \"skin.txt\"\n", "skin.txt:2: holds 3 numbers");
}

}  // namespace test_scene_thickness
}  // namespace limberg
