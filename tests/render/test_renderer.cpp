// Pictures by their properties: what stands at which pixel. Skipped only where there is no OSMesa.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "render/colour_map.h"
#include "render/image_compare.h"
#include "render/overlay.h"
#include "render/picture.h"
#include "render/renderer.h"
#include "tests/render/sample_head.h"
#include "tests/render/sample_snapshot.h"

namespace limberg {
namespace test_renderer {

using testing::sample_snapshot;
using testing::SampleOptions;

class Rendered : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    try {
      renderer = std::make_unique<Renderer>(make_osmesa_context());
    } catch (const RenderUnavailable& e) {
      why = e.what();
    }
  }
  static void TearDownTestSuite() { renderer.reset(); }
  void SetUp() override {
    if (!renderer) GTEST_SKIP() << why;
    options.width = 320, options.height = 240;
    camera = look_at_ball(Vec3f::Zero(), 18, Vec3f(0.05f, -0.6f, 0.8f), Vec3f::UnitZ(), 25, 320.0 / 240);
  }
  View view() const { return camera.view(double(options.width) / options.height); }
  Image draw(const Snapshot& s) {
    SceneBuilder builder;
    return renderer->draw(builder.build(s), view(), options);
  }
  IdImage ids(const Snapshot& s) {
    SceneBuilder builder;
    return renderer->draw_ids(builder.build(s), view(), options.width, options.height);
  }
  static size_t count(const IdImage& im, Part part) {
    size_t n = 0;
    for (const uint32_t id : im.id) n += (id >> 24) == uint32_t(part);
    return n;
  }

  static inline std::unique_ptr<Renderer> renderer;  // made once: warming the driver up takes half a second
  static inline std::string why;
  DrawOptions options;
  Camera camera;
};

TEST_F(Rendered, SameSceneSameBytes) {
  const Snapshot s = sample_snapshot();
  const Image a = draw(s), b = draw(s);
  EXPECT_EQ(a, b);
  Renderer other(make_osmesa_context());  // a second context in the same process
  SceneBuilder builder;
  EXPECT_EQ(other.draw(builder.build(s), view(), options), a);
  EXPECT_EQ(draw(s), a);  // the first is still whole
}

TEST_F(Rendered, EveryContextGivesTheSameBytes) {
  std::unique_ptr<GlContext> egl;
  try {
    egl = make_egl_context();
  } catch (const RenderUnavailable& e) {
    GTEST_SKIP() << e.what();
  }
  Renderer other(std::move(egl));
  // Byte for byte only where the same rasteriser stands behind both: a graphics card rounds as it likes.
  if (other.describe().find("llvmpipe") == std::string::npos) GTEST_SKIP() << "another driver: " << other.describe();
  const Snapshot s = sample_snapshot();
  SceneBuilder builder;
  for (const bool fine : {false, true}) {
    options.shadow = options.fine_skin = fine;
    const Image a = draw(s), b = other.draw(builder.build(s), view(), options);
    EXPECT_EQ(a, b) << renderer->describe() << " and " << other.describe();
  }
}

/// The slab of the sample with a picture of four quarters over all of it: red, green (above), blue, white (below).
Snapshot pictured() {
  Snapshot s = sample_snapshot({.wound = false, .sutures = 0, .hooks = 0});
  auto top = std::make_shared<SurfaceTopology>(*s.topology);
  top->version += 1;
  std::vector<std::array<Eigen::Vector2f, 3>> uv;
  for (size_t t = 0; t < top->view.tri.size(); ++t) {
    std::array<Eigen::Vector2f, 3> corner;
    for (size_t k = 0; k < 3; ++k) {
      const Vec3& X = std::as_const(top->view.X_mm)[size_t(std::as_const(top->view.tri)[t][k])];
      corner[k] = Eigen::Vector2f(float(X.x() / 60 + 0.5), float(X.y() / 60 + 0.5));
    }
    uv.push_back(corner);
  }
  top->view.uv = uv;
  auto image = std::make_shared<SkinImage>();
  image->width = image->height = 64;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const bool right = x >= 32, below = y >= 32;
      for (const int c : {!below  ? (right ? 40 : 220)
                          : right ? 220
                                  : 40,
                          !below  ? (right ? 220 : 40)
                          : right ? 220
                                  : 40,
                          below ? 220 : 40})
        image->rgb.push_back(uint8_t(c));
    }
  top->image = image;
  s.topology = top;
  return s;
}

TEST_F(Rendered, ThePictureOfASkinLiesWhereItsCoordinatesSay) {
  const Snapshot s = pictured();
  const Image im = draw(s);
  const auto at = [&](float x, float y) {
    const Vec3f p = view().to_pixel(Vec3f(x, y, 0), options.width, options.height);
    return im.at(int(p.x()), int(p.y()));
  };
  const Rgb8 red = at(-8, 6), green = at(8, 6), blue = at(-8, -6), white = at(8, -6);
  EXPECT_GT(red.r, 1.5 * std::max(red.g, red.b));
  EXPECT_GT(green.g, 1.5 * std::max(green.r, green.b));
  EXPECT_GT(blue.b, 1.5 * std::max(blue.r, blue.g));
  EXPECT_GT(std::min({white.r, white.g, white.b}), 150);
  // Without it, skin again.
  Snapshot bare = s;
  auto top = std::make_shared<SurfaceTopology>(*s.topology);
  top->version += 1, top->image = nullptr;
  bare.topology = top;
  const Image skin = draw(bare);
  const Vec3f p = view().to_pixel(Vec3f(-8, -6, 0), options.width, options.height);
  EXPECT_GT(skin.at(int(p.x()), int(p.y())).r, skin.at(int(p.x()), int(p.y())).b);
}

TEST_F(Rendered, AFaceWearsAPictureWhereItsColourSaysHowMuch) {
  Snapshot s = testing::sample_head();
  auto top = std::make_shared<SurfaceTopology>(*s.topology);
  top->version += 1;
  auto image = std::make_shared<SkinImage>();
  image->width = image->height = 4;
  for (int i = 0; i < 16; ++i) image->rgb.insert(image->rgb.end(), {30, 60, 230});
  top->image = image, top->image_on = Organ::face;
  // All of it on one side (x > 0), none on the other.
  for (size_t v = 0; v < top->view.X_mm.size(); ++v)
    top->rgba.push_back({0, 0, 0, uint8_t(std::as_const(top->view.X_mm)[v].x() > 0 ? 255 : 0)});
  s.topology = top;
  camera = look_at_ball(Vec3f::Zero(), 90, Vec3f(0, -1, 0), Vec3f::UnitZ(), 25, 320.0 / 240);
  const Image im = draw(s);
  const auto at = [&](float x) {
    const Vec3f p = view().to_pixel(Vec3f(x, -80, 10), options.width, options.height);
    return im.at(int(p.x()), int(p.y()));
  };
  const Rgb8 worn = at(20), skin = at(-20);
  EXPECT_GT(worn.b, 1.5 * worn.r);
  EXPECT_GT(skin.r, skin.b);
}

TEST_F(Rendered, AFaceHasItsOwnColours) {
  Snapshot s = testing::sample_head();
  auto top = std::make_shared<SurfaceTopology>(*s.topology);
  top->version += 1;
  top->rgba.assign(top->view.X_mm.size(), {30, 60, 230, 255});
  s.topology = top;
  camera = look_at_ball(Vec3f::Zero(), 90, Vec3f(0, -1, 0), Vec3f::UnitZ(), 25, 320.0 / 240);
  const Image im = draw(s);
  const IdImage id = ids(s);
  int seen = 0, blue = 0;
  for (int y = 0; y < im.height; ++y)
    for (int x = 0; x < im.width; ++x)
      if ((id.at(x, y) >> 24) == uint32_t(Part::face)) ++seen, blue += im.at(x, y).b > 1.2 * im.at(x, y).r;
  EXPECT_GT(seen, 500);
  EXPECT_GT(blue, 0.9 * seen);
}

// Half of a slab with a wound is a region of its own colour: its skin and its wall, and nothing of the other half.
TEST_F(Rendered, SkinAndWallHaveTheColoursOfARegion) {
  Snapshot s = sample_snapshot({.sutures = 0, .hooks = 0});
  auto top = std::make_shared<SurfaceTopology>(*s.topology);
  top->version += 1;
  top->rgba.assign(top->view.X_mm.size(), {});
  for (size_t v = 0; v < top->rgba.size(); ++v)
    if (std::as_const(top->view.X_mm)[v].x() > 0) top->rgba[v] = {30, 60, 230, 230};
  s.topology = top;
  const Image im = draw(s);
  const IdImage id = ids(s);
  std::map<std::pair<Part, bool>, std::pair<int, int>> blue;  // of how many
  for (int y = 0; y < im.height; ++y)
    for (int x = 0; x < im.width; ++x) {
      const Part part = Part(id.at(x, y) >> 24);
      if (part != Part::skin && part != Part::wall) continue;
      const Tri& t = std::as_const(top->view.tri)[id.at(x, y) & 0xffffff];
      const double a = std::as_const(top->view.X_mm)[size_t(t[0])].x(),
                   b = std::as_const(top->view.X_mm)[size_t(t[1])].x(),
                   c = std::as_const(top->view.X_mm)[size_t(t[2])].x();
      if (std::min({a, b, c}) <= 0 && std::max({a, b, c}) > 0) continue;
      auto& [found, all] = blue[{part, a > 0}];
      ++all, found += im.at(x, y).b > 1.1 * im.at(x, y).r;
    }
  for (const Part part : {Part::skin, Part::wall}) {
    SCOPED_TRACE(int(part));
    EXPECT_GT((blue[{part, true}].second), 200);
    EXPECT_GT((blue[{part, true}].first), 0.8 * (blue[{part, true}].second));
    EXPECT_GT((blue[{part, false}].second), 200);
    EXPECT_LT((blue[{part, false}].first), 0.02 * (blue[{part, false}].second));
  }
}

TEST_F(Rendered, PickedPixelHasTheTriangleThatLiesThere) {
  const Snapshot s = sample_snapshot({.sutures = 0, .hooks = 0});
  const IdImage im = ids(s);
  const SurfaceView& view_of = s.topology->view;
  // The centre of every large visible triangle must show that triangle. Hidden ones are found by their neighbours.
  int tested = 0;
  for (size_t t = 0; t < view_of.tri.size(); t += 7) {
    const Vec3f &a = s.x_mm[size_t(view_of.tri[t][0])], &b = s.x_mm[size_t(view_of.tri[t][1])],
                &c = s.x_mm[size_t(view_of.tri[t][2])];
    const Vec3f mid = (a + b + c) / 3;
    if (view_of.kind[t] != FaceKind::skin || std::abs(mid.x()) > 14 || std::abs(mid.y()) > 12) continue;
    const Vec3f p = view().to_pixel(mid, options.width, options.height);
    const int x = int(p.x()), y = int(p.y());
    if (x < 0 || y < 0 || x >= im.width || y >= im.height) continue;
    // A millimetre is about six pixels here, so the centre of a half-millimetre square triangle is inside it.
    EXPECT_EQ(im.at(x, y), uint32_t(Part::skin) << 24 | uint32_t(t)) << "triangle " << t;
    ++tested;
  }
  EXPECT_GT(tested, 50);
  EXPECT_GT(count(im, Part::wall), 500u);
  EXPECT_EQ(count(im, Part::suture), 0u);
}

TEST_F(Rendered, SutureAddsPixelsWhereItLies) {
  const Snapshot with = sample_snapshot({.hooks = 0}), without = sample_snapshot({.sutures = 0, .hooks = 0});
  const IdImage im = ids(with);
  EXPECT_GT(count(im, Part::suture), 150u);
  for (const SutureState& s : with.sutures) {
    size_t n = 0;
    for (const uint32_t id : im.id) n += id == (uint32_t(Part::suture) << 24 | uint32_t(s.id));
    EXPECT_GT(n, 20u) << "suture " << s.id;
  }
  options.shadow = false;
  const Image a = draw(with), b = draw(without);
  size_t changed = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      const bool suture = im.at(x, y) >> 24 == uint32_t(Part::suture);
      if (a.at(x, y) == b.at(x, y)) continue;
      ++changed;
      EXPECT_TRUE(suture) << x << ", " << y;  // without shadows a stitch changes only its own pixels
    }
  EXPECT_GT(changed, 100u);
}

TEST_F(Rendered, HookAndToolAreSeen) {
  const Snapshot s = sample_snapshot({.sutures = 0});
  EXPECT_GT(count(ids(s), Part::hook), 100u);
  for (const auto kind :
       {ToolPose::Kind::stylus, ToolPose::Kind::scalpel, ToolPose::Kind::hook, ToolPose::Kind::needle_holder}) {
    SceneBuilder builder;
    const ToolPose tool{true, kind, Vec3f(-5, 2, 1), Vec3f(-0.5f, -0.2f, 0.8f).normalized(), {}};
    EXPECT_GT(count(renderer->draw_ids(builder.build(s, tool), view(), 320, 240), Part::tool), 300u);
  }
}

// The bold line at chart x = -10 is a landmark: it must lie where the tissue's vertices of that chart line lie.
TEST_F(Rendered, GridFollowsTheVertices) {
  options.shadow = false, options.fine_skin = false;
  options.supersample = 3;
  // How dark the picture is at the vertex with this chart point.
  const auto darkness = [&](const Image& image, const Snapshot& snap, double chart_x, double chart_y) {
    const SurfaceView& v = snap.topology->view;
    for (size_t i = 0; i < v.X_mm.size(); ++i)
      if ((v.X_mm[i] - Vec3(chart_x, chart_y, 0)).norm() < 1e-6) {
        const Vec3f p = view().to_pixel(snap.x_mm[i], options.width, options.height);
        const Rgb8 c = image.at(int(p.x()), int(p.y()));
        return 255.0 - (c.r + c.g + c.b) / 3.0;
      }
    ADD_FAILURE() << "no vertex there";
    return 0.0;
  };
  SampleOptions o{.cells = 120, .wound = false, .wave_mm = 0, .sutures = 0, .hooks = 0};
  Snapshot flat = sample_snapshot(o), sheared = flat;
  for (Vec3f& x : sheared.x_mm) x.x() += 0.35f * x.y() + 2.5f;
  for (const Snapshot* s : {&flat, &sheared}) {
    const Image image = draw(*s);
    EXPECT_GT(darkness(image, *s, -10, 6.5), darkness(image, *s, -11.5, 6.5) + 20);
  }
}

TEST_F(Rendered, WallsShowTheirLayers) {
  const Snapshot s = sample_snapshot({.wave_mm = 0, .sutures = 0, .hooks = 0});
  camera = look_at_ball(Vec3f(0, 6, -3), 8, Vec3f(0, -0.9f, 0.45f), Vec3f::UnitZ(), 25, 320.0 / 240);
  const Image im = draw(s);
  const auto mean = [&](float z) {
    Vec3 sum = Vec3::Zero();
    for (float x = -2; x <= 2; x += 0.1f) {
      const Vec3f p = view().to_pixel(Vec3f(x, 6, z), 320, 240);
      const Rgb8 c = im.at(int(p.x()), int(p.y()));
      sum += Vec3(c.r, c.g, c.b);
    }
    return Vec3(sum / 41);
  };
  const Vec3 dermis = mean(-0.8f), fat = mean(-4);
  // Pale pink: red over green, little less blue than green. Fat is yellow: blue far below green.
  EXPECT_GT(dermis.x(), dermis.y());
  EXPECT_GT(fat.y() - fat.z(), dermis.y() - dermis.z() + 25);
}

TEST_F(Rendered, FieldColoursTheSkin) {
  Snapshot s = sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 0, .hooks = 0});
  options.colour_field = true, options.field_min = 0, options.field_max = 0.2, options.iso_lines = 0;
  std::vector<double> light;
  for (const float value : {0.0f, 0.05f, 0.10f, 0.15f, 0.20f}) {
    std::fill(s.field.begin(), s.field.end(), value);
    const Vec3f p = view().to_pixel(Vec3f(4.5f, 4.5f, 0), 320, 240);
    light.push_back(lightness(draw(s).at(int(p.x()), int(p.y()))));
  }
  for (size_t i = 1; i < light.size(); ++i) EXPECT_GT(light[i], light[i - 1] + 8);
}

TEST_F(Rendered, ShadowFallsUnderTheTool) {
  const Snapshot s = sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 0, .hooks = 0});
  SceneBuilder builder;
  const ToolPose tool{true, ToolPose::Kind::stylus, Vec3f(0, 0, 4), Vec3f(0.7f, 0, 0.7f).normalized(), {}};
  const Image with = renderer->draw(builder.build(s, tool), view(), options);
  options.shadow = false;
  const Image without = renderer->draw(builder.build(s, tool), view(), options);
  int darker = 0, lighter = 0;
  for (size_t i = 0; i < with.rgb.size(); i += 3)
    darker += with.rgb[i] + 20 < without.rgb[i], lighter += with.rgb[i] > without.rgb[i] + 20;
  EXPECT_GT(darker, 200);
  EXPECT_EQ(lighter, 0);
}

// How much darker occlusion makes the picture around a place: 1 = not at all.
double shade_by_occlusion(const Image& with, const Image& without, const Vec3f& at) {
  double a = 0, b = 0;
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      const Rgb8 p = with.at(int(at.x()) + dx, int(at.y()) + dy), q = without.at(int(at.x()) + dx, int(at.y()) + dy);
      a += p.r + p.g + p.b, b += q.r + q.g + q.b;
    }
  return a / b;
}

TEST_F(Rendered, ACreaseIsDarkerThanOpenSkinAndARidgeIsNot) {
  options.width = 480, options.height = 360;
  const Snapshot flat = sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 0, .hooks = 0});
  const auto folded = [&](float slope) {  // along y = 0, within 6 mm of it
    Snapshot s = flat;
    for (Vec3f& x : s.x_mm) x.z() += slope * (std::min(std::abs(x.y()), 6.0f) - 6.0f);
    return s;
  };
  const auto shade = [&](const Snapshot& s, const Vec3f& place) {
    options.occlusion = false;
    const Image without = draw(s);
    options.occlusion = true;
    return shade_by_occlusion(draw(s), without, view().to_pixel(place, options.width, options.height));
  };
  const Snapshot crease = folded(1.2f), ridge = folded(-1.2f);
  const double in_crease = shade(crease, Vec3f(2, 0, -7.2f)), beside = shade(crease, Vec3f(2, 14, 0)),
               on_ridge = shade(ridge, Vec3f(2, 0, 7.2f));
  EXPECT_LT(in_crease, 0.93);  // measured .90 on 2026-11-21
  EXPECT_GT(beside, 0.97);
  EXPECT_GT(on_ridge, 0.97);
  EXPECT_GT(shade(flat, Vec3f(2, 3, 0)), 0.99);
  // Only the tissue: behind it nothing changes.
  camera = look_at_ball(Vec3f::Zero(), 70, Vec3f(0, -0.6f, 0.8f), Vec3f::UnitZ(), 25, 480.0 / 360);
  options.occlusion = false;
  const Image without = draw(crease);
  options.occlusion = true;
  EXPECT_EQ(draw(crease).at(5, 5), without.at(5, 5));
}

TEST_F(Rendered, WhatHasNotMovedIsKeptAndWhatHasIsNot) {
  options.still = false;
  Snapshot s = sample_snapshot();
  const Image first = draw(s);
  EXPECT_EQ(draw(s), first);  // from the kept buffers and shadow
  for (Vec3f& x : s.x_mm) x.z() += 2;
  const Image moved = draw(s);
  EXPECT_NE(moved, first);
  Renderer fresh(make_osmesa_context());
  SceneBuilder builder;
  EXPECT_EQ(fresh.draw(builder.build(s), view(), options), moved);
  const ToolPose tool{true, ToolPose::Kind::stylus, Vec3f(0, 0, 4), Vec3f(0.7f, 0, 0.7f).normalized(), {}};
  EXPECT_EQ(fresh.draw(builder.build(s, tool), view(), options),
            renderer->draw(builder.build(s, tool), view(), options));
  EXPECT_EQ(draw(s), moved);
}

TEST_F(Rendered, AFrameDrawnSmallerIsEnlarged) {
  const Snapshot s = sample_snapshot();
  SceneBuilder builder;
  const View v = view();
  options.shadow = false;
  renderer->paint(builder.build(s), std::span(&v, 1), options);
  renderer->compose(options.width, options.height);
  const Image whole = renderer->read();
  options.shrink = 2;
  renderer->paint(builder.build(s), std::span(&v, 1), options);
  EXPECT_EQ(renderer->read().width, options.width / 2);
  renderer->compose(options.width, options.height);
  const Image half = renderer->read();
  ASSERT_EQ(half.width, options.width);
  EXPECT_NE(half, whole);
  EXPECT_LT(block_mean_difference(whole, half, 32), 20);  // the same picture, less sharp
}

TEST_F(Rendered, SignedValuesAreBlueAndRed) {
  Snapshot s = sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 0, .hooks = 0});
  options.colour_field = true, options.scale = ColourScale::signed_value, options.field_min = -2, options.field_max = 2,
  options.iso_lines = 0;
  const auto at = [&](float value) {
    std::fill(s.field.begin(), s.field.end(), value);
    const Vec3f p = view().to_pixel(Vec3f(4.5f, 4.5f, 0), 320, 240);
    return draw(s).at(int(p.x()), int(p.y()));
  };
  const Rgb8 low = at(-1.9f), zero = at(0), high = at(1.9f);
  EXPECT_GT(low.b, low.r + 40);
  EXPECT_GT(high.r, high.b + 40);
  EXPECT_LT(std::max({zero.r, zero.g, zero.b}) - std::min({zero.r, zero.g, zero.b}), 12);
  for (int i = 0; i <= 20; ++i)  // neither sign looks stronger, and lightness falls evenly away from zero
    EXPECT_NEAR(lightness(diverging(-0.05 * i)), lightness(diverging(0.05 * i)), 3.5) << i;
  for (int i = 0; i < 20; ++i) EXPECT_GT(lightness(diverging(0.05 * i)), lightness(diverging(0.05 * (i + 1))) + 1) << i;
}

TEST_F(Rendered, LinesAreSeenThroughTissueButFaintly) {
  const Snapshot s = sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 0, .hooks = 0});
  options.shadow = false;
  const auto changed = [&](float z) {
    SceneBuilder builder;
    const RenderScene& scene = builder.build(s);  // valid until it is built again: lines are added to it
    const Image without = renderer->draw(scene, view(), options);
    SceneLines lines;
    lines.add(Vec3f(-8, 1, z), Vec3f(8, 1, z), Vec3f(0, 0.6f, 1));
    builder.add_lines(lines);
    const Image with = renderer->draw(scene, view(), options);
    long sum = 0;
    for (size_t i = 0; i < with.rgb.size(); ++i) sum += std::abs(int(with.rgb[i]) - int(without.rgb[i]));
    return sum;
  };
  const long above = changed(1), below = changed(-3);
  EXPECT_GT(above, 10000);
  EXPECT_GT(below, 2000);
  EXPECT_LT(below, 0.6 * double(above));
}

// Where the lines run differently in different places, so do the dashes: along y on the one half, along x on the other.
TEST_F(Rendered, TensionLinesByPlaceRunAsTheyDoThere) {
  Snapshot s = sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 0, .hooks = 0});
  auto topology = std::make_shared<SurfaceTopology>(*s.topology);
  auto body = std::make_shared<Body>(*topology->body);
  body->surface.X_mm.assign(topology->view.X_mm.begin(), topology->view.X_mm.end());
  body->surface.tri.assign(topology->view.tri.begin(), topology->view.tri.end());
  for (const Vec3& X : body->surface.X_mm) body->tension.push_back(X.x() < 0 ? Vec3f::UnitY() : Vec3f::UnitX());
  for (size_t t = 0; t < topology->view.tri.size(); ++t) topology->view.origin.set(t, int32_t(t));
  topology->body = body;
  s.topology = topology;
  options.shadow = false;
  const Image plain = draw(s);
  options.tension_lines = true;
  const Image lined = draw(s);
  // Of a dark pixel the neighbour along the lines is dark as well; the one across hardly ever is.
  const auto dark = [&](const Vec3f& at) {
    const Vec3f p = view().to_pixel(at, options.width, options.height);
    return lined.at(int(p.x()), int(p.y())).r + 20 < plain.at(int(p.x()), int(p.y())).r;
  };
  for (const float middle : {-14.f, 14.f}) {
    int all = 0, along_x = 0, along_y = 0;
    for (float x = middle - 10; x <= middle + 10; x += 0.2f)
      for (float y = -12; y <= 12; y += 0.2f)
        if (dark({x, y, 0})) ++all, along_x += dark({x + 1, y, 0}), along_y += dark({x, y + 1, 0});
    EXPECT_GT(all, 200);
    EXPECT_GT(middle < 0 ? along_y : along_x, 2 * (middle < 0 ? along_x : along_y)) << middle;
  }
}

TEST_F(Rendered, TensionLinesRunAlongTheTension) {
  const Snapshot s = sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 0, .hooks = 0});
  options.shadow = false;
  const Image plain = draw(s);
  options.tension_lines = true;
  const Image lined = draw(s);
  // A dash lies on y = 0 (along x, the body's direction of tension); none half way to the next.
  const auto darker = [&](float y) {
    int n = 0;
    for (float x = -12; x <= 12; x += 0.25f) {
      const Vec3f p = view().to_pixel(Vec3f(x, y, 0), options.width, options.height);
      n += lined.at(int(p.x()), int(p.y())).r + 20 < plain.at(int(p.x()), int(p.y())).r;
    }
    return n;
  };
  EXPECT_GT(darker(0), 35);
  EXPECT_LT(darker(2), 4);
}

TEST_F(Rendered, TwoViewsFillTheirHalves) {
  const Snapshot s = sample_snapshot();
  SceneBuilder builder;
  const RenderScene& scene = builder.build(s);
  const auto eyes = camera.stereo_side_by_side(320.0 / 240);
  const Image both = renderer->draw(scene, eyes, options);
  EXPECT_NE(both.at(80, 120), (Rgb8{0, 0, 0}));
  EXPECT_NE(both.at(240, 120), (Rgb8{0, 0, 0}));
  const Image left = renderer->draw(scene, std::span(eyes.data(), 1), options);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 160; ++x) ASSERT_EQ(left.at(x, y), both.at(x, y));
  EXPECT_EQ(left.at(300, 120), (Rgb8{0, 0, 0}));
}

// The measure of the other image tests must fail on real defects of real pictures, and pass harmless ones.
TEST_F(Rendered, ComparisonCatchesPlantedDefects) {
  options.width = 640, options.height = 480;
  const Snapshot s = sample_snapshot();
  const Image good = draw(s);
  Snapshot lost = s;
  lost.sutures.pop_back();
  EXPECT_GT(block_mean_difference(good, draw(lost)), 4);
  auto holed = std::make_shared<SurfaceTopology>(*s.topology);
  Snapshot hole = s;
  for (size_t t = 0; t < holed->view.tri.size(); ++t) {  // two skin triangles lost
    const Vec3& X = holed->view.X_mm[size_t(holed->view.tri[t][0])];
    if (holed->view.kind[t] == FaceKind::skin && (X - Vec3(4, -10, 0)).norm() < 1e-6) holed->view.tri[t] = {0, 0, 0};
  }
  holed->hash ^= 1;
  hole.topology = holed;
  EXPECT_GT(block_mean_difference(good, draw(hole)), 4);
  DrawOptions smooth = options;
  std::swap(smooth, options);
  options.shadow = false;
  EXPECT_GT(block_mean_difference(good, draw(s)), 4);
  options = smooth;
  camera.eye_mm += Vec3f(0.002f, 0, 0);  // far below a pixel
  EXPECT_LT(block_mean_difference(good, draw(s)), 4);
}

TEST_F(Rendered, PictureHasCaptionAndLegend) {
  PictureMaker maker(480, 320);
  const Snapshot s = sample_snapshot();
  maker.focus_from(s);
  const Image plain = maker.skin(s), titled = maker.skin(s, [] {
    PictureOptions o;
    o.title = "Flap cut";
    return o;
  }());
  if (!TextPainter().ready()) GTEST_SKIP() << "the font DejaVu Sans is not installed";
  int white = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 240; ++x)
      white += titled.at(x, y) == Rgb8{255, 255, 255} && !(plain.at(x, y) == Rgb8{255, 255, 255});
  EXPECT_GT(white, 50);
  // The legend holds every colour of the map, low end below, high end above.
  const Image map = maker.tension(s);
  int low = -1, high = -1;
  for (int y = 0; y < map.height; ++y)
    for (int x = map.width * 3 / 4; x < map.width; ++x) {
      const auto near = [&](Rgb8 c) {
        const Rgb8 p = map.at(x, y);
        return std::abs(p.r - c.r) + std::abs(p.g - c.g) + std::abs(p.b - c.b) < 8;
      };
      if (near(viridis(0.03))) low = y;
      if (high < 0 && near(viridis(0.97))) high = y;
    }
  EXPECT_GT(low, 0);
  EXPECT_GT(high, 0);
  EXPECT_LT(high, low);
}

TEST_F(Rendered, CameraOfAMakerStandsStill) {
  PictureMaker maker(320, 240);
  Snapshot s = sample_snapshot();
  maker.focus_from(s);
  const Vec3f eye = maker.camera().eye_mm;
  for (Vec3f& x : s.x_mm) x += Vec3f(1, 2, 3);
  maker.skin(s);
  maker.tension(s);
  EXPECT_EQ(maker.camera().eye_mm, eye);
  PictureMaker empty(64, 64);
  EXPECT_NO_THROW(empty.skin(Snapshot{}));
  EXPECT_NO_THROW(empty.tension(Snapshot{}));
}

TEST(Context, RefusalSaysWhatToDo) {
  try {
    make_osmesa_context({.library = "libNoSuchThing.so.1"});
    FAIL() << "made a context out of nothing";
  } catch (const RenderUnavailable& e) {
    EXPECT_NE(std::string(e.what()).find("no pictures"), std::string::npos) << e.what();
  }
  EXPECT_THROW(make_osmesa_context({.major = 9, .minor = 9}), RenderUnavailable);
}

TEST_F(Rendered, TooLargeIsRefused) {
  options.width = 200000;
  EXPECT_THROW(draw(sample_snapshot()), RenderUnavailable);
}

TEST_F(Rendered, TheGloveIsSeenWhereItIsAndOnlyThen) {
  options.shadow = false;  // the skin is as it was but where they cover it
  const Snapshot s = sample_snapshot();
  const auto drawn = [&](const ToolPose& tool) {
    SceneBuilder builder;
    return renderer->draw(builder.build(s, tool), view(), options);
  };
  ToolPose tool;
  tool.glove.forefinger_mm = Vec3f(-6, 2, 14), tool.glove.thumb_mm = Vec3f(-14, 2, 14),
  tool.glove.pointing = -Vec3f::UnitZ();
  tool.glove.points = true, tool.glove.pointed_mm = Vec3f(-6, 2, 0.8f);
  const Image none = draw(s);
  EXPECT_EQ(drawn(tool), none) << "not visible";
  tool.glove.visible = true;
  const Image open = drawn(tool);
  const auto differs = [&](const Image& a, const Image& b, const Vec3f& at_mm, int reach) {
    const Vec3f p = view().to_pixel(at_mm, options.width, options.height);
    int n = 0;
    for (int y = int(p.y()) - reach; y <= int(p.y()) + reach; ++y)
      for (int x = int(p.x()) - reach; x <= int(p.x()) + reach; ++x)
        n += x >= 0 && y >= 0 && x < options.width && y < options.height &&
             std::abs(a.at(x, y).r - b.at(x, y).r) + std::abs(a.at(x, y).g - b.at(x, y).g) +
                     std::abs(a.at(x, y).b - b.at(x, y).b) >
                 40;
    return n;
  };
  EXPECT_GT(differs(none, open, tool.glove.forefinger_mm, 6), 60);
  EXPECT_GT(differs(none, open, tool.glove.thumb_mm, 6), 60);
  EXPECT_GT(differs(none, open, tool.glove.pointed_mm, 4), 20);
  EXPECT_EQ(differs(none, open, Vec3f(14, -4, 0), 8), 0) << "elsewhere the skin is as it was";
  tool.glove.closed = true;
  const Image empty = drawn(tool);
  EXPECT_GT(differs(open, empty, tool.glove.forefinger_mm, 6), 60) << "another colour";
  EXPECT_EQ(differs(none, empty, tool.glove.pointed_mm, 4), 0) << "a closed hand that holds nothing points at nothing";
  tool.glove.holds = true;
  EXPECT_GT(differs(none, drawn(tool), tool.glove.pointed_mm, 4), 20);
}

}  // namespace test_renderer
}  // namespace limberg
