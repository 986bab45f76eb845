// Undermining along what is held: the sheet keeps its distance from bone whose depth below the skin changes, falls off
// gently where bone ends, and is refused where there is none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/body/skin.h"
#include "sim/cutting/strokes/drawn_stroke.h"
#include "tests/sim/cutting/body_on_bone.h"

namespace limberg {
namespace test_along_held {

/// A slab of 60 x 40 mm, flat above. Below it is held along a slope, 4 mm below the skin at x = -30 and 12 at x = 10,
/// and free from there to x = 30, at 12 mm.
std::shared_ptr<const Body> wedge() {
  const std::string obj =
      "v -30 -20 0\nv 30 -20 0\nv 30 20 0\nv -30 20 0\n"
      "v -30 -20 -4\nv 10 -20 -12\nv 10 20 -12\nv -30 20 -4\nv 30 -20 -12\nv 30 20 -12\n"
      "usemtl skin\nf 1 2 3 4\nusemtl cut\nf 1 5 6\nf 1 6 9 2\nf 2 9 10 3\nf 3 10 7\nf 3 7 8 4\nf 4 8 5 1\n"
      "f 6 7 10 9\nusemtl bone\nf 5 8 7 6\n";
  return test::body_on_bone(obj);
}

struct Slab {
  std::shared_ptr<const Body> body = wedge();
  Skin skin{body};
  Arrangement a{body->surface, body->grid};

  BladeContext context() {
    return {body.get(), &a, [this](const ChartPoint& p) { return skin.at(p); }};
  }
  BladeResult sheet(double x0, double x1, double depth_mm, double above_mm) {
    return build_undermining(context(), std::vector<Vec2>{{x0, -12}, {x1, -12}, {x1, 12}, {x0, 12}}, depth_mm,
                             {&skin, above_mm});
  }
  /// Of the bone below a place, mm below the skin.
  static double bone_mm(double x) { return 8 + 0.2 * (x + 10); }
};

TEST(AlongHeld, TheSheetKeepsItsDistanceFromTheBone) {
  Slab s;
  const BladeResult r = s.sheet(-24, 4, 20, 0.8);
  ASSERT_TRUE(r.blade) << r.reason;
  ASSERT_GT(r.blade->vertex.size(), 50u);
  double least = 1e9, most = -1e9;
  for (const Int3& v : r.blade->vertex) {
    const Vec3 X = s.body->grid.to_mm(v);
    // Along the skin's normal, which is upright here: the grid's rounding, and the even grid's jitter.
    const double above = X.z() + Slab::bone_mm(X.x());
    least = std::min(least, above), most = std::max(most, above);
  }
  EXPECT_NEAR(least, 0.8, 0.01);
  EXPECT_NEAR(most, 0.8, 0.01);
}

TEST(AlongHeld, ItIsNoDeeperThanAskedAndFallsOffGentlyWhereBoneEnds) {
  Slab s;
  const BladeResult r = s.sheet(-24, 26, 9, 0.8);  // bone lies deeper than 9 mm from x = -5 on, and ends at 10
  ASSERT_TRUE(r.blade) << r.reason;
  for (const Int3& v : r.blade->vertex) {
    const Vec3 X = s.body->grid.to_mm(v);
    EXPECT_LE(-X.z(), 9) << X.transpose();
    if (X.x() < -7) EXPECT_NEAR(X.z() + Slab::bone_mm(X.x()), 0.8, 0.01) << X.transpose();
    if (X.x() > 0) EXPECT_NEAR(-X.z(), 9, 0.3) << X.transpose();  // kSheetRaise above the depth asked
  }
  for (const Tri& t : r.blade->tri) {
    const Vec3 p = s.body->grid.to_mm(r.blade->vertex[size_t(t[0])]),
               q = s.body->grid.to_mm(r.blade->vertex[size_t(t[1])]);
    EXPECT_LE(std::abs(p.z() - q.z()), 0.71 * (p - q).norm()) << "35 degrees";
  }
}

TEST(AlongHeld, WhatIsThinIsPartedHalfWay) {
  Slab s;
  const BladeResult r = s.sheet(-28, -20, 20, 6);  // 4.4 to 6 mm thick there
  ASSERT_TRUE(r.blade) << r.reason;
  for (const Int3& v : r.blade->vertex) {
    const Vec3 X = s.body->grid.to_mm(v);
    EXPECT_NEAR(-X.z(), 0.5 * Slab::bone_mm(X.x()), 0.01);
  }
}

TEST(AlongHeld, NothingHeldIsRefusedInWords) {
  Slab s;
  const BladeResult deep = s.sheet(14, 26, 20, 0.5), shallow = s.sheet(-4, 4, 5, 0.5);
  EXPECT_FALSE(deep.blade);
  EXPECT_NE(deep.reason.find("nothing is held within 20 mm"), std::string::npos) << deep.reason;
  EXPECT_FALSE(shallow.blade);
  EXPECT_NE(shallow.reason.find("nothing is held within 5 mm"), std::string::npos) << shallow.reason;
}

/// An incision down to the bone and a pocket from it: the tissue over the pocket comes off the bone, and a slice of so
/// many mm stays on it.
TEST(AlongHeld, TheFlapComesOffAndItsSliceStays) {
  Slab s;
  const double before = s.a.volume_mm3();
  const auto line = [&](std::vector<Vec2> path) {
    int cuts = 0;
    const CutResult r = incise(s.a, s.context(), path, 11, 90, 7, false, &cuts);
    ASSERT_TRUE(r.ok()) << r.reason;
  };
  line({{-20, 10}, {-20, -10}, {0, -10}, {0, 10}, {-20, 10}});
  const BladeResult sheet =
      build_undermining(s.context(), std::vector<Vec2>{{-20, -10}, {0, -10}, {0, 10}, {-20, 10}}, 20, {&s.skin, 0.8});
  ASSERT_TRUE(sheet.blade) << sheet.reason;
  const CutResult r = s.a.cut(*sheet.blade, 9);
  ASSERT_TRUE(r.ok()) << r.reason;
  EXPECT_EQ(s.a.check_all(), "");
  ASSERT_EQ(s.a.pieces(), 3) << "the island, its slice, which walls to the bone part from the rest, and the rest";
  const ExciseResult e = s.a.excise(s.a.loose_component_near({-10, 0, -1}, 10));
  ASSERT_TRUE(e.done);
  // 20 x 20 mm, as thick as to .8 mm above the bone: 8 mm less .8 in the middle. The sheet's triangles lie in a plane.
  EXPECT_NEAR(e.volume_mm3, 20 * 20 * (Slab::bone_mm(-10) - 0.8), 0.003 * e.volume_mm3);
  EXPECT_NEAR(s.a.volume_mm3() + e.volume_mm3, before, 1e-9 * before);
}

}  // namespace test_along_held
}  // namespace limberg
