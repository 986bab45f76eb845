// Kept pictures: of skin and of a head, each way they can be
// shown, against small reference pictures in tests/render/golden.
//
// A reference is the picture of 320 x 240 pixels made eight times
// smaller: a pixel of it is the mean of a block of 8 x 8, so that
// the worst block of 16 x 16 of the whole picture, which is what is
// judged (image_compare.h), can be had from it. LIMBERG_GOLDEN=write
// makes them anew. The references were drawn by Mesa 22.3 in
// software; other versions of it came within 3 of 255 of each other.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "app/program/places.h"
#include "render/image_compare.h"
#include "render/picture.h"
#include "render/renderer.h"
#include "tests/render/sample_head.h"
#include "tests/render/sample_snapshot.h"

namespace limberg {
namespace test_pictures {

namespace fs = std::filesystem;
using testing::sample_head;
using testing::sample_snapshot;

constexpr int kWidth = 320, kHeight = 240, kBlock = 8;
constexpr double kLimit = 4;  // of 255: above what drivers differ by, below any defect that a reader would mind

class Pictures : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    try {
      renderer = std::make_unique<Renderer>(make_offscreen_context());
    } catch (const RenderUnavailable& e) {
      why = e.what();
    }
  }
  static void TearDownTestSuite() { renderer.reset(); }
  void SetUp() override {
    if (!renderer) GTEST_SKIP() << why;
    o.width = kWidth, o.height = kHeight;
  }

  static Camera of_skin() {
    return look_at_ball(Vec3f::Zero(), 18, Vec3f(0.05f, -0.6f, 0.8f), Vec3f::UnitZ(), 25, double(kWidth) / kHeight);
  }
  static Camera of_head() {
    return look_at_ball(Vec3f(0, -20, 0), 85, Vec3f(0.35f, -0.9f, 0.15f), Vec3f::UnitZ(), 25, double(kWidth) / kHeight);
  }
  Image draw(const Snapshot& s, const Camera& camera) {
    SceneBuilder builder;
    return renderer->draw(builder.build(s), camera.view(double(kWidth) / kHeight), o);
  }
  Image red_cyan(const Snapshot& s, const Camera& camera) {
    SceneBuilder builder;
    const auto eyes = camera.stereo_pair(double(kWidth) / kHeight, 12);
    renderer->paint_anaglyph(builder.build(s), eyes[0], eyes[1], o);
    return renderer->read();
  }
  Image wipe(const Snapshot& before, const Snapshot& after, const Camera& camera) {
    SceneBuilder left_builder, right_builder;
    const View whole = camera.view(double(kWidth) / kHeight), left = whole.part(0, 0.5f), right = whole.part(0.5f, 1);
    renderer->paint(left_builder.build(before), std::span(&left, 1), o);
    DrawOptions second = o;
    second.keep = true;
    renderer->paint(right_builder.build(after), std::span(&right, 1), second);
    return renderer->read();
  }
  void of_field(double most) { o.colour_field = true, o.field_min = 0, o.field_max = most, o.iso_lines = 4; }

  /// How far a picture is from its reference; a lack of the reference is a failure.
  static double off(const Image& picture, const std::string& name) {
    const fs::path file = fs::path(source_dir()) / "tests" / "render" / "golden" / (name + ".png");
    const Image small = shrink(picture, kBlock);
    if (const char* wish = std::getenv("LIMBERG_GOLDEN"); wish && std::string(wish) == "write") {
      fs::create_directories(file.parent_path());
      write_png(file, small);
      return 0;
    }
    if (!fs::exists(file)) {
      ADD_FAILURE() << file << ": no such reference; LIMBERG_GOLDEN=write makes it";
      return 255;
    }
    const double d = block_mean_difference(read_png(file), small, 2);
    if (d > kLimit) {
      const fs::path kept = fs::temp_directory_path() / ("limberg-" + name + ".png");
      write_png(kept, picture);
      std::printf("the picture that differs is kept: %s\n", kept.c_str());
    }
    return d;
  }

  static inline std::unique_ptr<Renderer> renderer;
  static inline std::string why;
  DrawOptions o;
};

TEST_F(Pictures, AreAsTheyWere) {
  const Snapshot skin = sample_snapshot(), head = sample_head(), moved = sample_head(8);
  EXPECT_LT(off(draw(skin, of_skin()), "skin"), kLimit);
  EXPECT_LT(off(draw(head, of_head()), "face"), kLimit);
  EXPECT_LT(off(red_cyan(head, of_head()), "face-red-cyan"), kLimit);
  EXPECT_LT(off(wipe(head, moved, of_head()), "face-wipe"), kLimit);
  o.face = FaceLook::clear;
  EXPECT_LT(off(draw(moved, of_head()), "face-clear"), kLimit);
  o.face = FaceLook::hidden;
  EXPECT_LT(off(draw(moved, of_head()), "bone"), kLimit);
  o.face = FaceLook::solid;
  of_field(8);
  EXPECT_LT(off(draw(moved, of_head()), "face-moved"), kLimit);
  o.colour_field = false, o.wireframe = true;
  EXPECT_LT(off(draw(head, of_head()), "face-triangles"), kLimit);
  o.wireframe = false;
  of_field(0.2);
  EXPECT_LT(off(draw(skin, of_skin()), "skin-stretch"), kLimit);
}

// The limit parts what nobody sees from what a reader would mind, on the pictures of the head as well.
TEST_F(Pictures, PlantedDefectsOfAHeadAreCaught) {
  if (const char* wish = std::getenv("LIMBERG_GOLDEN"); wish) GTEST_SKIP() << "references are being made";
  const Snapshot head = sample_head();
  Camera nudged = of_head();
  nudged.eye_mm.x() += 0.05f;  // a tenth of a pixel
  EXPECT_LT(off(draw(head, nudged), "face"), kLimit);

  Snapshot dented = head;  // a dent of 4 mm, 16 mm wide
  for (size_t v = 0; v < dented.x_mm.size(); ++v)
    if (const float d = (dented.x_mm[v] - Vec3f(12, -84, 32)).norm(); d < 8) dented.x_mm[v].y() += 4 * (1 - d / 8);
  EXPECT_GT(off(draw(dented, of_head()), "face"), kLimit);
  o.shadow = false;
  EXPECT_GT(off(draw(sample_head(8), of_head()), "bone"), kLimit) << "a face where bone should be";
  o.shadow = true;
  of_field(8);
  Snapshot more = sample_head(8);
  for (float& m : more.moved_mm) m *= 1.05f;  // a map of 5 % too much
  EXPECT_GT(off(draw(more, of_head()), "face-moved"), kLimit);
  o.colour_field = false;
  {
    SceneBuilder builder;  // eyes exchanged
    const auto eyes = of_head().stereo_pair(double(kWidth) / kHeight, 12);
    renderer->paint_anaglyph(builder.build(head), eyes[1], eyes[0], o);
    EXPECT_GT(off(renderer->read(), "face-red-cyan"), kLimit);
  }
  EXPECT_GT(off(wipe(sample_head(8), head, of_head()), "face-wipe"), kLimit) << "before and after exchanged";
}

TEST_F(Pictures, TheFaceHidesTheBoneUntilItIsClear) {
  const Snapshot moved = sample_head(8);
  SceneBuilder builder;
  const RenderScene& scene = builder.build(moved);
  const View view = of_head().view(double(kWidth) / kHeight);
  const IdImage ids = renderer->draw_ids(scene, view, kWidth, kHeight);
  size_t face = 0, bone = 0;
  for (const uint32_t id : ids.id) face += id >> 24 == uint32_t(Part::face), bone += id >> 24 == uint32_t(Part::bone);
  EXPECT_GT(face, 20000u);
  EXPECT_EQ(bone, 0u);
  // A clear face is neither a solid one nor none.
  const auto look = [&](FaceLook wanted) {
    o.face = wanted;
    return draw(moved, of_head());
  };
  const Image solid = look(FaceLook::solid), clear = look(FaceLook::clear), hidden = look(FaceLook::hidden);
  const auto differing = [&](const Image& a, const Image& b) {
    size_t n = 0;
    for (size_t i = 0; i < a.rgb.size(); i += 3)
      n += std::abs(a.rgb[i] - b.rgb[i]) + std::abs(a.rgb[i + 1] - b.rgb[i + 1]) +
               std::abs(a.rgb[i + 2] - b.rgb[i + 2]) >
           20;
    return n;
  };
  EXPECT_GT(differing(solid, hidden), face / 2);
  EXPECT_GT(differing(clear, solid), face / 4);
  EXPECT_GT(differing(clear, hidden), face / 4);
}

TEST_F(Pictures, ALandmarkIsNamedOnWhatItLiesOnWhateverItIsCalled) {
  PictureMaker pictures(kWidth, kHeight);
  pictures.set_camera(of_head());
  // Where the face and the bone under it are seen: above the middle.
  const auto front = [](bool face) {
    const Snapshot s = sample_head(8);
    Vec3f at(0, 0, 0);
    for (size_t t = 0; t < s.topology->view.tri.size(); ++t)
      for (const int32_t v : s.topology->view.tri[t])
        if (const Vec3f& x = s.x_mm[size_t(v)]; (s.topology->organ_of(t) == Organ::face) == face &&
                                                std::abs(x.x()) < 10 && std::abs(x.z() - 28) < 10 && x.y() < at.y())
          at = x;
    return at;
  };
  const auto drawn = [&](FaceLook look, bool on_face, const char* name) {
    Snapshot s = sample_head(8);
    auto t = std::make_shared<SurfaceTopology>(*s.topology);
    t->landmark = {name};
    s.topology = t;
    s.landmark_mm = {front(on_face)};
    PictureOptions p;
    p.face = look, p.landmarks = *name != 0;
    return pictures.skin(s, p);
  };
  for (const FaceLook look : {FaceLook::solid, FaceLook::hidden}) {
    const Image none = drawn(look, false, "");
    for (const bool on_face : {false, true})
      for (const char* name : {"M1", "m1"})
        EXPECT_EQ(drawn(look, on_face, name) == none, on_face != (look == FaceLook::solid))
            << int(look) << on_face << name;
  }
}

TEST_F(Pictures, AnAnaglyphGivesEachEyeItsPicture) {
  // Red carries the left eye, blue the right one: each agrees better with its own eye's picture than with the other's.
  const Snapshot head = sample_head();
  const Image both = red_cyan(head, of_head());
  SceneBuilder builder;
  const RenderScene& scene = builder.build(head);
  const auto eyes = of_head().stereo_pair(double(kWidth) / kHeight, 12);
  const Image left = renderer->draw(scene, eyes[0], o), right = renderer->draw(scene, eyes[1], o);
  const auto correlation = [&](int channel, const Image& eye) {
    double sa = 0, sb = 0, aa = 0, bb = 0, ab = 0;
    const size_t n = both.rgb.size() / 3;
    for (size_t i = 0; i < n; ++i) {
      const double a = both.rgb[3 * i + size_t(channel)],
                   b = (eye.rgb[3 * i] + eye.rgb[3 * i + 1] + eye.rgb[3 * i + 2]) / 3.0;
      sa += a, sb += b, aa += a * a, bb += b * b, ab += a * b;
    }
    return (ab - sa * sb / double(n)) / std::sqrt((aa - sa * sa / double(n)) * (bb - sb * sb / double(n)));
  };
  EXPECT_GT(correlation(0, left), correlation(0, right));
  EXPECT_GT(correlation(2, right), correlation(2, left));
}

TEST_F(Pictures, TheMapOfMovementIsDarkWhereNothingMovedAndBrightWhereItDid) {
  of_field(8);
  o.iso_lines = 0;
  const Image map = draw(sample_head(8), of_head());
  const View view = of_head().view(double(kWidth) / kHeight);
  const auto bright = [&](const Vec3f& at) {
    const Vec3f p = view.to_pixel(at, kWidth, kHeight);
    const Rgb8 c = map.at(int(p.x()), int(p.y()));
    return int(c.g);  // grows along the map
  };
  EXPECT_GT(bright(Vec3f(0, -94, 28)), bright(Vec3f(30, -82, 0)) + 20);
  EXPECT_GT(bright(Vec3f(30, -82, 0)), bright(Vec3f(20, -70, -50)) + 5);
}

TEST_F(Pictures, TrianglesLetTheBackgroundThrough) {
  const Snapshot head = sample_head();
  const Image solid = draw(head, of_head());
  o.wireframe = true;
  const Image wire = draw(head, of_head());
  size_t covered = 0, lines = 0;
  SceneBuilder builder;
  const IdImage ids =
      renderer->draw_ids(builder.build(head), of_head().view(double(kWidth) / kHeight), kWidth, kHeight);
  o.wireframe = false, o.face = FaceLook::hidden;
  const Snapshot nothing;
  const Image empty = draw(nothing, of_head());
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      if (ids.at(x, y) >> 24 == uint32_t(Part::face)) ++covered, lines += !(wire.at(x, y) == empty.at(x, y));
  EXPECT_GT(lines, covered / 20);
  EXPECT_LT(lines, covered * 19 / 20);
  EXPECT_FALSE(solid == wire);
}

}  // namespace test_pictures
}  // namespace limberg
