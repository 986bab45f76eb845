// Scenes: the shipped ones load and make a body, every mistake is named with its line, any bytes are survived.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "app/program/places.h"
#include "app/program/temporary_folder.h"
#include "app/scene/scene.h"
#include "render/image.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "tests/render/jpeg_bytes.h"

namespace limberg {
namespace test_scene {

const std::string kScenes = source_dir() + "/app/scenes/";

const std::string kGood = R"(name = "t"
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

// Without the line that starts with `key`, and with `line` in its place.
std::string with(const std::string& key, const std::string& line) {
  std::string t = kGood;
  const size_t a = t.find("\n" + key) + 1, b = t.find('\n', a);
  return t.replace(a, b - a, line);
}

/// A box as an OBJ with texture coordinates, a material and a picture beside it.
struct PicturedBox {
  TemporaryFolder folder{"texture"};
  PicturedBox() {
    write(
        "box.obj",
        "mtllib box.mtl\nv -15 -10 0\nv 15 -10 0\nv 15 10 0\nv -15 10 0\nv -15 -10 9\nv 15 -10 9\nv 15 10 9\nv -15 10 "
        "9\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 5/1 6/2 7/3 8/4\nf 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 "
        "7\nf 4 1 5 8\n");
    write("box.mtl", "newmtl m\nmap_Kd -clamp on box.png\n");
    Image image(2, 2);
    image.set(0, 0, {200, 10, 20});
    write("box.png", encode_png(image));
    write("own.png", encode_png(Image(3, 1, {9, 9, 9})));
  }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder.path() / name, std::ios::binary) << bytes;
  }
  WorldSpec spec(const std::string& key = "") const {
    const std::string text =
        "name = \"t\"\n[body]\nsource = \"obj\"\nmesh = \"box.obj\"\n" + key + kGood.substr(kGood.find("[[layer]]"));
    const Scene scene = parse_scene(text, (folder.path() / "scene.toml").string());
    return world_spec(scene, build_body(scene));
  }
};

TEST(SceneTexture, IsWhatTheSceneSaysOrTheMaterialNames) {
  const PicturedBox box;
  const WorldSpec by_material = box.spec();
  ASSERT_TRUE(by_material.image);
  EXPECT_EQ(by_material.image->width, 2);
  EXPECT_EQ(by_material.image->rgb[0], 200) << "the upper left";
  EXPECT_EQ(box.spec("texture = \"own.png\"\n").image->width, 3);
  box.write("box.mtl", "newmtl m\nmap_Kd gone.png\n");
  EXPECT_FALSE(box.spec().image) << "a material may name what was not handed on";
  box.write("box.mtl", "newmtl m\nmap_Kd box.jpg\n");
  EXPECT_FALSE(box.spec().image);
  box.write("box.jpg", test::jpeg_bytes(Image(4, 2, {210, 160, 140})));
  ASSERT_TRUE(box.spec().image) << "a photograph";
  EXPECT_EQ(box.spec().image->width, 4);
  EXPECT_NEAR(box.spec().image->rgb[0], 210, 3);
  box.write("box.tga", "no kind that is read");
  box.write("box.mtl", "newmtl m\nmap_Kd box.tga\n");
  EXPECT_FALSE(box.spec().image);
}

TEST(SceneTexture, BadPicturesAreRefusedWithTheirName) {
  const PicturedBox box;
  box.write("own.png", "no picture");
  for (const std::string name : {"own.png", "missing.png"}) try {
      box.spec("texture = \"" + name + "\"\n");
      ADD_FAILURE() << name;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
    }
  box.write("box.png", "no picture");
  EXPECT_THROW(box.spec(), InputError);
}

TEST(Scene, ShippedBlocksLoad) {
  for (const char* name : {"rhomboid", "zplasty"}) {
    const Scene s = load_scene(find_scene(name, {"/nowhere", kScenes}));
    EXPECT_EQ(s.name, name);
    EXPECT_FALSE(s.text.empty());
    SurfaceReport r;
    const auto body = build_body(s, &r);
    EXPECT_GE(body->surface.tri.size(), 50000u);
    EXPECT_EQ(r.volume_mm3, 144000);
    ASSERT_EQ(body->layers.size(), 2u);
    EXPECT_EQ(body->layers[0].thickness_mm, 1.5);
    EXPECT_EQ(body->layers[1].thickness_mm, 8.5);
    EXPECT_DOUBLE_EQ(body->layers[1].material.density_kg_mm3, 920e-9);
    const WorldSpec w = world_spec(s, body);
    EXPECT_EQ(w.cell_mm, 5);
    EXPECT_EQ(w.wound_level, 2);
    EXPECT_EQ(w.body, body);
  }
  const Scene a = load_scene(kScenes + "rhomboid.toml"), b = load_scene(kScenes + "zplasty.toml");
  EXPECT_NE(a.hash, b.hash);
  EXPECT_EQ(a.hash, load_scene(kScenes + "rhomboid.toml").hash);
  const Scene said = parse_scene("# another word\n" + a.text, a.path), other = parse_scene(b.text, a.path);
  EXPECT_NE(said.hash, a.hash) << "a recording holds the very text";
  EXPECT_TRUE(differs_in_words_only(a, said.text, said.hash)) << "but it is the same patient";
  EXPECT_FALSE(differs_in_words_only(a, other.text, other.hash));
  EXPECT_FALSE(differs_in_words_only(a, said.text, said.hash + 1)) << "with other files beside it";
}

TEST(Scene, TheFaceIsTaggedByItsMaterials) {
  SurfaceReport r;
  const auto body = build_body(load_scene(kScenes + "face.toml"), &r);
  EXPECT_EQ(r.genus, 0);
  size_t held = 0;
  for (SurfaceTag t : body->surface.tag) held += t == SurfaceTag::fixed;
  EXPECT_GT(held, body->surface.tag.size() / 10);
  EXPECT_LT(held, body->surface.tag.size() * 9 / 10);
}

// The directions of a deep side, on a face that somebody else has made.
TEST(Scene, ARealFaceByItsDirections) {
  const char* data = std::getenv("LIMBERG_DATA");
  if (!data) GTEST_SKIP() << "LIMBERG_DATA does not name the folder of the test data";
  const std::string mesh = std::string(data) + "/face/wholeFace_NasalCartilage.obj";
  if (!std::filesystem::exists(mesh)) GTEST_SKIP() << mesh << " is absent";
  ObjSpec o;
  o.path = mesh, o.scale_to_mm = 10;
  o.deep_center_mm = Vec3(0, -40, -40), o.deep_angle_deg = 80;
  SurfaceReport r;
  const Body body = load_obj(o, &r);
  EXPECT_EQ(r.genus, 5);
  size_t held = 0;
  for (SurfaceTag t : body.surface.tag) held += t == SurfaceTag::fixed;
  EXPECT_GT(held, body.surface.tag.size() / 10);
  EXPECT_LT(held, body.surface.tag.size() * 9 / 10);
}

TEST(Scene, ASurfaceThatIsMissingIsNamed) {
  try {
    build_body(
        parse_scene("[body]\nsource = \"obj\"\nmesh = \"absent.obj\"\n[[layer]]\nname = \"skin\"\nthickness_mm = "
                    "2\nyoung_kPa = 60\npoisson = 0.45\ndensity_kg_m3 = 1000\n",
                    "x/t.toml"));
    ADD_FAILURE();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("absent.obj"), std::string::npos) << e.what();
  }
}

TEST(Scene, DefaultsAndUnits) {
  const Scene s = parse_scene(kGood, "x/t.toml");
  EXPECT_EQ(s.block.size_mm, Vec3(30, 20, 8));
  EXPECT_EQ(s.cell_mm, 2);
  EXPECT_TRUE(s.can_cut);
  EXPECT_EQ(s.layers().size(), 1u);
  EXPECT_EQ(s.layers()[0].material.prestretch_along, 1);
  EXPECT_NEAR((s.camera.eye_mm() - s.camera.target_mm).norm(), s.camera.distance_mm, 1e-9);
}

TEST(Scene, EveryMistakeIsNamedWithItsLine) {
  const std::tuple<std::string, int, const char*> cases[] = {
      {"", 0, "empty"},
      {" \n\n", 0, "empty"},
      {"name = \n", 1, "broken TOML"},
      {"[body\n", 1, "broken TOML"},
      {"name = \"a\"\nname = \"b\"\n", 2, "broken TOML"},
      {"name = \"a\"\n", 0, "[body] is missing"},
      {kGood + "[colours]\n", 12, "unknown key \"colours\""},
      {kGood + "cell = 3\n", 12, "unknown key \"cell\" in [lattice]"},
      {"body = 3\n", 1, "not a table"},
      {with("source", "source = \"sphere\""), 3, "no known kind"},
      {with("source", "source = 3"), 3, "not a text"},
      {with("size_mm", "size_mm = [30, 20]"), 4, "three numbers"},
      {with("size_mm", "size_mm = [30, 20, \"a\"]"), 4, "finite number"},
      {with("size_mm", "size_mm = [30, -20, 8]"), 4, "expected 1 to 1000"},
      {with("size_mm", "size_mm = [30, nan, 8]"), 4, "finite number"},
      {with("size_mm", "size_mm = [30, inf, 8]"), 4, "finite number"},
      {with("size_mm", "skin_cell_mm = 0"), 4, "skin_cell_mm is 0"},
      {with("size_mm", "mesh = \"a.obj\""), 4, "unknown key \"mesh\""},
      {with("size_mm", "tension_direction = [0, 0, 1]"), 4, "upright"},
      {with("size_mm", "tension_direction = [0, 0, 0]"), 4, "no length"},
      {with("thickness_mm", "thickness_mm = -1"), 7, "layer.thickness_mm is -1"},
      {with("thickness_mm", "thickness_mm = nan"), 7, "nan"},
      {with("young_kPa", "young_kPa = 0"), 8, "above 0"},
      {with("poisson", "poisson = 0.5"), 9, "0.499"},
      {with("poisson", ""), 5, "is missing"},
      {with("[[layer]]", "[layer]"), 5, "no layers"},
      {with("cell_mm", "cell_mm = 9"), 11, "larger than the block"},
      {with("cell_mm", "cell_mm = -2"), 11, "cell_mm is -2"},
      {with("cell_mm", "cell_mm = nan"), 11, "nan"},
      {with("cell_mm", "cell_mm = true"), 11, "not a number"},
      {kGood + "wound_cell_mm = 3\n", 12, "lattice.wound_cell_mm is 3; expected 0.25 to 2 mm"},
      {kGood + "wound_cell_mm = 0.2\n", 12, "an eighth of cell_mm"},
      {kGood + "wound_cell_mm = -1\n", 12, "from 0"},
      {kGood + "fine = 3\n", 12, "lattice.fine is no list"},
      {kGood + "fine = [3]\n", 12, "lattice.fine 1 is no table"},
      {kGood + "fine = [{radius_mm = 3, cell_mm = 1}]\n", 12, "at_mm is missing"},
      {kGood + "fine = [{at_mm = [0, 0], cell_mm = 1}]\n", 12, "radius_mm is missing"},
      {kGood + "fine = [{at_mm = [0, 0], radius_mm = 3}]\n", 12, "cell_mm is missing"},
      {kGood + "fine = [{at_mm = [0], radius_mm = 3, cell_mm = 1}]\n", 12, "is no place"},
      {kGood + "fine = [{at_mm = [0, inf], radius_mm = 3, cell_mm = 1}]\n", 12, "is no place"},
      {kGood + "fine = [{at_mm = [0, 0], to_mm = 4, radius_mm = 3, cell_mm = 1}]\n", 12, "to_mm is no place"},
      {kGood + "fine = [{at_mm = [0, 0], radius_mm = 0, cell_mm = 1}]\n", 12,
       "radius_mm is 0; expected a number above"},
      {kGood + "fine = [{at_mm = [0, 0], radius_mm = 3, cell_mm = 1, depth_mm = -1}]\n", 12, "depth_mm is -1"},
      {kGood + "fine = [{at_mm = [0, 0], radius_mm = 3, cell_mm = 1, size = 1}]\n", 12, "unknown key \"size\""},
      {kGood +
           "fine = [\n{at_mm = [0, 0], radius_mm = 3, cell_mm = 1},\n{at_mm = [1, 0], radius_mm = 3, cell_mm = 4}]\n",
       14, "lattice.fine 2.cell_mm is 4; expected 0.25 to 2 mm"},
      {kGood + "fine = [{at_mm = [0, 0], to_mm = [999, 0], radius_mm = 900, cell_mm = 0.25}]\n", 12, "2 million cells"},
      {with("size_mm", "sliding_sides = \"-x\""), 4, "body.sliding_sides is no list"},
      {with("size_mm", "sliding_sides = [\"+z\"]"), 4, "a side that a block does not have; expected a list of \"-x\""},
      {with("size_mm", "free_sides = [3]"), 4, "a side that a block does not have"},
      {with("size_mm", "sliding_sides = [\"-x\"]\nfree_sides = [\"-x\"]"), 5, "-x, which is named before"},
      {with("size_mm", "free_sides = [\"-x\", \"+x\", \"-y\", \"+y\", \"-z\"]"), 4, "names every side"},
      {kGood + "[loads]\ngravity_m_s2 = 9.81\n", 13, "three numbers"},
      {kGood + "[loads]\ngravity_m_s2 = [0, 0, 1e3]\n", 13, "at most 100"},
      {kGood + "[loads]\ngravity = [0, 0, 1]\n", 13, "unknown key \"gravity\" in [loads]; expected gravity_m_s2"},
      {kGood + "[loads]\ncell_mm = 6\n", 13, "expected 0.25 to 2 mm, an eighth of cell_mm"},
      {kGood + "[loads]\npatches = 1\n", 13, "loads.patches is no list"},
      {kGood + "[loads]\npatches = [1]\n", 13, "loads.patches 1 is no table"},
      {kGood + "[loads]\npatches = [{at_mm = [0, 0]}]\n", 13, "force_N is missing"},
      {kGood + "[loads]\npatches = [{at_mm = [0, 0], force_N = [0, 0, nan]}]\n", 13, "finite numbers"},
      {kGood + "[loads]\npatches = [{at_mm = [0, 0], force_N = [0, 0, 1], radius_mm = 30}]\n", 13, "from 0 to 20"},
      {kGood + "[solver]\niterations_per_step = 1.5\n", 13, "not an integer"},
      {kGood + "[solver]\nseed = -1\n", 13, "from 0"},
      {kGood + "[build]\ncan_cut = 1\n", 13, "neither true nor false"},
      {kGood + "[build]\ncontact = \"maybe\"\n", 13, "neither \"auto\" nor true nor false"},
      {kGood + "[camera]\nfrom = [0, 0, 2]\n", 12, "across"},
      {kGood + "[tools]\nmax_depth_mm = 2\n", 12, "default_depth_mm"},
  };
  for (const auto& [text, line, word] : cases) {
    try {
      parse_scene(text, "s.toml");
      ADD_FAILURE() << "accepted:\n" << text << "\nexpected: " << word;
    } catch (const InputError& e) {
      EXPECT_EQ(e.line(), line) << e.what();
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what() << "\nexpected: " << word;
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
}

TEST(Scene, FineCellsArePartsOfCells) {
  const Scene s = parse_scene(kGood + R"(wound_cell_mm = 0.9
fine = [
  {at_mm = [3, 4], radius_mm = 5, cell_mm = 0.5},
  {at_mm = [-9, 0], to_mm = [9, 1], radius_mm = 2, cell_mm = 2, depth_mm = 3},
  {at_mm = [0, 0], radius_mm = 1, cell_mm = 0.25},
]
)",
                              "s.toml");
  EXPECT_EQ(s.wound_level, 1);  // .9 mm is nearest to a half of 2 mm
  ASSERT_EQ(s.fine.size(), 3u);
  EXPECT_EQ(s.fine[0].level, 2);
  EXPECT_TRUE(s.fine[0].to == ChartPoint(3, 4) && s.fine[0].depth_mm > 1e9);
  EXPECT_EQ(s.fine[1].level, 0);
  EXPECT_TRUE(s.fine[1].to == ChartPoint(9, 1) && s.fine[1].depth_mm == 3);
  EXPECT_EQ(s.fine[2].level, 3);
  const auto body = build_body(s);
  const WorldSpec w = world_spec(s, body);
  EXPECT_TRUE(w.fine == s.fine && w.wound_level == 1);
  const WorldSpec plain = world_spec(parse_scene(kGood, "s.toml"), body);
  EXPECT_TRUE(plain.fine.empty() && plain.wound_level == 0);

  try {
    build_body(
        parse_scene(kGood + "fine = [\n  {at_mm = [0, 0], to_mm = [16, 0], radius_mm = 3, cell_mm = 1}]\n", "s"));
    ADD_FAILURE() << "off the skin";
  } catch (const InputError& e) {
    EXPECT_EQ(e.line(), 13) << e.what();
    EXPECT_NE(std::string(e.what()).find("[16, 0], off the skin"), std::string::npos) << e.what();
  }
  std::string many = "fine = [";
  for (int i = 0; i < 40; ++i) many += "{at_mm = [0, 0], radius_mm = 1, cell_mm = 1},";
  EXPECT_THROW(parse_scene(kGood + many + "]\n", "s"), InputError);
}

TEST(Scene, LoadsAndSides) {
  const Scene s = parse_scene(
      with("size_mm", "size_mm = [30, 20, 8]\nsliding_sides = [\"-x\", \"-z\"]\nfree_sides = [\"+y\"]") + R"(
[loads]
gravity_m_s2 = [0, -9.81, 0]
patches = [
  {at_mm = [3, 4], force_N = [0, 0, -0.5], radius_mm = 5},
  {at_mm = [-3, 4], force_N = [1, 0, 0]},
]
)",
      "s.toml");
  const auto body = build_body(s);
  EXPECT_EQ(body->sliding_sides, 0b10001);
  size_t open = 0, held = 0;
  for (size_t t = 0; t < body->surface.tri.size(); ++t) {
    bool high_y = true;
    for (int32_t v : body->surface.tri[t]) high_y = high_y && body->surface.X_mm[size_t(v)].y() == 10;
    open += body->surface.tag[t] == SurfaceTag::free, held += body->surface.tag[t] == SurfaceTag::fixed;
    if (high_y) {
      EXPECT_EQ(body->surface.tag[t], SurfaceTag::free);
    }
  }
  EXPECT_GT(open, 10u);
  EXPECT_GT(held, 3 * open);
  const WorldSpec w = world_spec(s, body);
  EXPECT_EQ(w.gravity_m_s2, Vec3(0, -9.81, 0));
  ASSERT_EQ(w.loads.size(), 2u);
  EXPECT_TRUE((w.loads[0] == SkinLoad{{3, 4}, {0, 0, -0.5}, 5}));
  EXPECT_TRUE((w.loads[1] == SkinLoad{{-3, 4}, {1, 0, 0}, 2}));
  // Smaller cells around each load, unless the scene says otherwise.
  ASSERT_EQ(w.fine.size(), 2u);
  EXPECT_TRUE((w.fine[0] == FineZone{{3, 4}, {3, 4}, 13, FineZone{}.depth_mm, 1}));
  const std::string one = "patches = [{at_mm = [0, 0], force_N = [0, 0, 1]}]\n";
  for (const auto& [cell_mm, zones, level] : {std::tuple("2", 0, 0), {"1", 1, 1}, {"0.5", 1, 2}}) {
    const Scene of = parse_scene(kGood + "[loads]\ncell_mm = " + cell_mm + "\n" + one, "s.toml");
    ASSERT_EQ(world_spec(of, build_body(of)).fine.size(), size_t(zones)) << cell_mm;
    EXPECT_EQ(of.load_level, level) << cell_mm;
  }
  const WorldSpec plain = world_spec(parse_scene(kGood, "s.toml"), build_body(parse_scene(kGood, "s.toml")));
  EXPECT_TRUE(plain.gravity_m_s2.isZero(0) && plain.loads.empty() && plain.body->sliding_sides == 0);
  try {
    build_body(parse_scene(kGood + "[loads]\npatches = [\n  {at_mm = [16, 0], force_N = [0, 0, 1]}]\n", "s"));
    ADD_FAILURE() << "off the skin";
  } catch (const InputError& e) {
    EXPECT_EQ(e.line(), 14) << e.what();
    EXPECT_NE(std::string(e.what()).find("loads.patches 1 is at [16, 0], off the skin"), std::string::npos) << e.what();
  }
}

TEST(Scene, Colliders) {
  namespace fs = std::filesystem;
  const TemporaryFolder folder;
  const std::string file = (fs::path(folder.path()) / "tooth.obj").string();
  write_whole_file(file, "v 0 0 2\nv 9 0 2\nv 0 9 2\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  const std::string beside = (fs::path(folder.path()) / "s.toml").string();
  const std::string two = "[[collider]]\nmesh = \"tooth.obj\"\ncolour = [1, 0.5, 0]\n[[collider]]\nmesh = \"" + file +
                          "\"\nscale_to_mm = 2\n";
  const Scene s = parse_scene(kGood + two, beside);
  const auto body = build_body(s);
  ASSERT_EQ(body->colliders.size(), 2u);
  EXPECT_EQ(body->colliders[0]->name, "tooth");
  EXPECT_EQ(body->colliders[0]->colour, Vec3f(1, 0.5f, 0));
  EXPECT_EQ(body->colliders[1]->mesh.X_mm[3], Vec3(0, 0, 18));
  EXPECT_NE(s.hash, parse_scene(kGood, beside).hash);
  const uint64_t before = s.hash;
  write_whole_file(file, "v 0 0 2\nv 9 0 2\nv 0 9 2\nv 0 0 8\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  EXPECT_NE(parse_scene(kGood + two, beside).hash, before) << "the scene is another one when the file is";
  const auto why = [&](const std::string& text) -> std::string {
    try {
      build_body(parse_scene(kGood + text, beside));
      return "";
    } catch (const InputError& e) {
      return e.what();
    }
  };
  EXPECT_NE(why("[collider]\nmesh = \"tooth.obj\"\n").find("collider is no list of 1 to 16 tables"), std::string::npos);
  EXPECT_NE(why("[[collider]]\ncolour = [1, 0, 0]\n").find("collider.mesh is missing"), std::string::npos);
  EXPECT_NE(why("[[collider]]\nmesh = \"tooth.obj\"\ncolour = [1, -1, 0]\n").find("part below 0"), std::string::npos);
  EXPECT_NE(why("[[collider]]\nmesh = \"tooth.obj\"\nsoft = 1\n").find("unknown key"), std::string::npos);
  EXPECT_NE(why("[[collider]]\nmesh = \"none.obj\"\n").find("none.obj"), std::string::npos);
}

TEST(Scene, FilesThatAreNoScenes) {
  namespace fs = std::filesystem;
  EXPECT_THROW(load_scene("/no/such/scene.toml"), InputError);
  EXPECT_THROW(load_scene(fs::temp_directory_path()), InputError);
  EXPECT_THROW(load_scene("/dev/null"), InputError);
  EXPECT_THROW(parse_scene(std::string(2 << 20, '#'), "s"), InputError);
  EXPECT_THROW(parse_scene(std::string(100'000, '['), "s"), InputError);
  try {
    find_scene("rhombus", {kScenes});
    ADD_FAILURE();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find(
                  "craniofacial, ear, face, face_side, forehead_flap, head, lids, lips, mouth, nose, prognathic, "
                  "retrognathic, rhomboid, scalp, zplasty"),
              std::string::npos)
        << e.what();
  }
}

TEST(Scene, AFolderOfTheNameIsNotTheScene) {
  namespace fs = std::filesystem;
  const fs::path before = fs::current_path(),
                 here = fs::temp_directory_path() / ("limberg-scene-" + std::to_string(getpid()));
  fs::create_directories(here / "rhomboid");  // as --out rhomboid leaves one
  fs::current_path(here);
  EXPECT_EQ(fs::path(find_scene("rhomboid", {kScenes})).filename(), "rhomboid.toml");
  fs::current_path(before);
  fs::remove_all(here);
}

TEST(Scene, AnyBytesAreASceneOrAnInputError) {
  std::mt19937_64 rng(3);
  const std::string spice = "[]{}=\".,0123456789-\n\\#e\xff\x01 ";
  int refused = 0;
  for (int n = 0; n < 5000; ++n) {
    std::string t = kGood;
    for (int k = 1 + int(rng() % 3); k > 0 && !t.empty(); --k) {
      const size_t at = rng() % t.size();
      if (rng() % 3 == 0)
        t.erase(at, 1 + rng() % 9);
      else
        t[at] = spice[rng() % spice.size()];
    }
    try {
      parse_scene(t, "f.toml");
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace test_scene
}  // namespace limberg
