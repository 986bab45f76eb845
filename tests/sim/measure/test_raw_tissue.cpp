// A flap of known size above flat skin: on its back, on its edge, as it should lie, beneath skin, cut free.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/measure/raw_tissue.h"
#include "tests/sim/measure/views.h"

namespace limberg {
namespace test_raw_tissue {

constexpr double kLong_mm = 6, kWide_mm = 4, kThick_mm = 1;

// A slab over the middle of the block that leans about x, its skin on the side of -z where `on_its_back`. A triangle
// joins it to a vertex of the block, so that the body holds it.
struct Flap {
  SurfaceView view;
  std::vector<Vec3f> x_mm;
  int32_t first = 0;
};

Flap flap_over(const Body& body, double height_mm, double lean_deg, bool on_its_back, bool held = true) {
  Flap f{view_of(body), {}, 0};
  SurfaceView& v = f.view;
  f.x_mm = deformed(v, [](const Vec3& X) { return X; });
  f.first = int32_t(v.X_mm.size());
  const Mat3 turn = Eigen::AngleAxisd(lean_deg * std::numbers::pi / 180, Vec3::UnitX()).toRotationMatrix();
  for (const double z : {0.0, kThick_mm})
    for (const double y : {0.0, kWide_mm})
      for (const double x : {0.0, kLong_mm}) {
        v.X_mm.push_back({x, y, -z});
        f.x_mm.push_back((turn * Vec3(x, y, z) + Vec3(0, 0, height_mm)).cast<float>());
      }
  const auto quad = [&](int a, int b, int c, int d, FaceKind kind) {  // counter-clockwise from outside
    for (const Tri& t : {Tri{a, b, c}, Tri{a, c, d}}) {
      v.tri.push_back({f.first + t[0], f.first + t[1], f.first + t[2]});
      v.kind.push_back(kind);
    }
  };
  quad(0, 2, 3, 1, on_its_back ? FaceKind::skin : FaceKind::wall);  // looks down
  quad(4, 5, 7, 6, on_its_back ? FaceKind::wall : FaceKind::skin);  // looks up
  quad(0, 1, 5, 4, FaceKind::wall), quad(2, 6, 7, 3, FaceKind::wall);
  quad(0, 4, 6, 2, FaceKind::wall), quad(1, 3, 7, 5, FaceKind::wall);
  if (held) v.tri.push_back({0, f.first, f.first + 1}), v.kind.push_back(FaceKind::skin);
  return f;
}

RawTissue raw_of(const Flap& f, const Skin& skin) { return raw_tissue(f.view, f.x_mm, skin); }

TEST(RawTissue, AFlapOnItsBackShowsAllOfIt) {
  const auto body = measured_block({40, 40, 10}, 4);
  const Skin skin(body);
  const RawTissue raw = raw_of(flap_over(*body, 2, 0, true), skin);
  EXPECT_NEAR(raw.area_mm2, kLong_mm * kWide_mm, 1e-4);
  EXPECT_NEAR(raw.height_mm, 2 + kThick_mm, 1e-5);
  EXPECT_LT((raw.at_mm - Vec3(3, 2, -1)).norm(), 1e-4);
}

TEST(RawTissue, AFlapThatLeansCountsUntilItsRawSideLooksSideways) {
  const auto body = measured_block({40, 40, 10}, 4);
  const Skin skin(body);
  constexpr double kBroad_mm2 = kLong_mm * kWide_mm, kEdge_mm2 = kLong_mm * kThick_mm;
  EXPECT_NEAR(raw_of(flap_over(*body, 2, 25, true), skin).area_mm2, kBroad_mm2, 1e-3);
  // At 55 degrees the edge that came to lie on top looks up as well, at 65 it alone.
  EXPECT_NEAR(raw_of(flap_over(*body, 2, 55, true), skin).area_mm2, kBroad_mm2 + kEdge_mm2, 1e-3);
  EXPECT_NEAR(raw_of(flap_over(*body, 2, 65, true), skin).area_mm2, kEdge_mm2, 1e-3);
}

TEST(RawTissue, WhatLiesAsItShouldIsBelowOrIsHiddenIsNone) {
  const auto body = measured_block({40, 40, 10}, 4);
  const Skin skin(body);
  EXPECT_EQ(raw_of(flap_over(*body, 2, 0, false), skin).area_mm2, 0);    // skin up
  EXPECT_EQ(raw_of(flap_over(*body, -0.6, 0, true), skin).area_mm2, 0);  // .4 mm above: a step
  Flap under = flap_over(*body, 2, 0, true);
  const auto n = int32_t(under.view.X_mm.size());
  for (const Vec3& p : {Vec3(-20, -20, 6), Vec3(40, -20, 6), Vec3(-20, 40, 6)})
    under.view.X_mm.push_back(p), under.x_mm.push_back(p.cast<float>());
  under.view.tri.push_back({n, n + 1, n + 2}), under.view.kind.push_back(FaceKind::skin);
  EXPECT_EQ(raw_of(under, skin).area_mm2, 0);
}

TEST(RawTissue, APieceThatNothingHoldsIsNone) {
  const auto body = measured_block({40, 40, 10}, 4);
  EXPECT_EQ(raw_of(flap_over(*body, 2, 0, true, false), Skin(body)).area_mm2, 0);
}

}  // namespace test_raw_tissue
}  // namespace limberg
