// The materials of an OBJ say what its faces are.
#include <gtest/gtest.h>

#include <algorithm>

#include "app/import/import.h"
#include "app/program/temporary_folder.h"
#include "app/scene/scene.h"
#include "render/image.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/body/obj.h"
#include "tests/app/import/peer_fixture.h"

namespace limberg {
namespace test_tagged_surface {

using test::PeerFixture;
using What = ObjTag::What;

std::string refused(const std::function<void()>& f) {
  try {
    f();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(TaggedSurface, EachMaterialIsWhatItIsSaidToBe) {
  const PeerFixture f;
  ObjSpec spec;
  spec.path = "slab.obj", spec.scale_to_mm = 10;
  spec.tags = {{"1", What::held_softly}, {"2", What::skin}, {"7", What::held}};
  const Body b = parse_obj(f.obj, spec);
  const auto count = [](const Body& body, SurfaceTag t) {
    return std::count(body.surface.tag.begin(), body.surface.tag.end(), t);
  };
  const long bone = 12 * 16 * 2, sides = 16 * 2 + 2 * 24 * 2;
  EXPECT_EQ(count(b, SurfaceTag::fixed), bone);
  EXPECT_EQ(count(b, SurfaceTag::free), sides);
  EXPECT_EQ(std::count(b.soft_kPa_mm.begin(), b.soft_kPa_mm.end(), 0.75f), sides);
  EXPECT_EQ(std::count(b.soft_kPa_mm.begin(), b.soft_kPa_mm.end(), 0.0f), long(b.surface.tri.size()) - sides);
  EXPECT_EQ(count(b, SurfaceTag::skin), long(b.surface.tri.size()) - bone - sides);
  for (size_t t = 0; t < b.surface.tri.size(); ++t) {
    const Vec3& X = b.surface.X_mm[size_t(b.surface.tri[t][0])];
    if (X.z() == 12 && X.y() > 0 && X.y() < 40 && X.x() > 0 && X.x() < 60) {
      EXPECT_EQ(b.surface.tag[t], SurfaceTag::skin);
    }
  }
  spec.tags[2].what = What::cut;
  EXPECT_EQ(count(parse_obj(f.obj, spec), SurfaceTag::free), bone + sides);
  // A tag for each material, and none for others.
  spec.tags.pop_back();
  EXPECT_NE(refused([&] { parse_obj(f.obj, spec); }).find("material '7', which is not tagged"), std::string::npos);
  spec.tags.push_back({"8", What::held});
  EXPECT_NE(refused([&] { parse_obj(f.obj, spec); }).find("no faces of material '8'"), std::string::npos);
  spec.tags = {{"1", What::held}, {"2", What::held}, {"7", What::held}};
  EXPECT_NE(refused([&] { parse_obj(f.obj, spec); }).find("expected some skin"), std::string::npos);
}

TEST(TaggedSurface, ASceneRefusesWhatItCannotMean) {
  const PeerFixture f;
  const TemporaryFolder folder;
  const auto at = [&](const char* name) { return (folder.path() / name).string(); };
  write_whole_file(at("slab.smd"), PeerFixture::scene());
  write_whole_file(at("slab.obj"), f.obj);
  const Imported x = import_peer({at("slab.smd"), {}, folder.path().string(), 10, 0, 0});
  EXPECT_EQ(x.bed_file, "");
  write_whole_file(at("slab.obj"), surface_obj(x));
  const std::string good = scene_toml(x);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string s = good;
    s.replace(s.find(from), from.size(), to);
    return refused([&] { build_body(parse_scene(s, at("slab.toml"))); });
  };
  EXPECT_EQ(with("name", "name"), "");
  EXPECT_NE(with("\"held_softly\"", "\"sticky\"").find("what is of no known kind"), std::string::npos);
  EXPECT_NE(with("material = \"2\"", "material = \"1\"").find("tagged twice"), std::string::npos);
  EXPECT_NE(with("what = \"skin\"", "colour = \"red\"").find("what is missing"), std::string::npos);
  EXPECT_NE(with("what = \"skin\"", "what = \"skin\"\nwhere = 1").find("unknown key"), std::string::npos);
  EXPECT_NE(with("source = \"obj\"", "source = \"obj\"\ndeep_angle_deg = 10").find("expected one of them"),
            std::string::npos);
}

TEST(TaggedSurface, ThePictureOfThePeersSkinIsCarriedIfItIsThereAndWhole) {
  const PeerFixture f;
  const TemporaryFolder folder;
  const auto at = [&](const char* name) { return (folder.path() / name).string(); };
  std::string scene = PeerFixture::scene();
  scene.insert(1, "\"textureFiles\":{\"other.jpg\":2,\"skin.jpg\":1},");
  write_whole_file(at("slab.smd"), scene);
  write_whole_file(at("slab.obj"), f.obj);
  const auto import = [&] { return import_peer({at("slab.smd"), {}, folder.path().string(), 10, 0, 0}); };
  const auto told = [](const Imported& x, const std::string& what) {
    return std::any_of(x.missing.begin(), x.missing.end(),
                       [&](const std::string& m) { return m.find(what) != std::string::npos; });
  };
  EXPECT_TRUE(told(import(), "is not drawn: it is not there"));
  EXPECT_EQ(scene_toml(import()).find("texture"), std::string::npos);
  write_whole_file(at("skin.jpg"), "no picture");
  EXPECT_TRUE(told(import(), "neither a PNG nor a JPEG"));
  Image image(6, 5, {200, 150, 140});
  write_whole_file(at("skin.jpg"), encode_png(image));  // whatever its name
  const Imported x = import();
  EXPECT_FALSE(told(x, "The picture of the skin, "));
  EXPECT_EQ(picture_name(x), "slab.png");
  EXPECT_NE(scene_toml(x).find("texture = \"slab.png\""), std::string::npos);
  write_whole_file(at("slab.obj"), surface_obj(x));
  write_whole_file(at("slab.png"), x.texture);
  const Scene ours = parse_scene(scene_toml(x), at("slab.toml"));
  const WorldSpec spec = world_spec(ours, build_body(ours));
  ASSERT_TRUE(spec.image);
  EXPECT_EQ(spec.image->rgb, image.rgb);
}

}  // namespace test_tagged_surface
}  // namespace limberg
