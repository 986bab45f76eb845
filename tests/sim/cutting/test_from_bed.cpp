// A cut right through that begins on the bed of a pocket: what lies below is parted, the flap above stays whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/body/skin.h"
#include "sim/cutting/strokes/drawn_stroke.h"
#include "tests/sim/cutting/body_on_bone.h"

namespace limberg {
namespace test_from_bed {

constexpr double kBed_mm = 3, kThick_mm = 9;

/// A slab of 60 x 24 mm, held at its left end, free elsewhere; skin above.
std::shared_ptr<const Body> slab() {
  const std::string obj =
      "v -30 -12 0\nv 30 -12 0\nv 30 12 0\nv -30 12 0\nv -30 -12 -9\nv 30 -12 -9\nv 30 12 -9\nv -30 12 -9\n"
      "usemtl skin\nf 1 2 3 4\nusemtl cut\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 5 8 7 6\nusemtl bone\nf 4 8 5 1\n";
  return test::body_on_bone(obj);
}

struct Pocketed {
  std::shared_ptr<const Body> body = slab();
  Skin skin{body};
  Arrangement a{body->surface, body->grid};
  SkinView view;

  BladeContext context() {
    return {body.get(), &a, [this](const ChartPoint& p) { return skin.at(p); }};
  }
  /// An incision across, and a pocket to its right.
  Pocketed() {
    int cuts = 0;
    const std::vector<Vec2> across{{-14, -9}, {-14, 9}};
    EXPECT_TRUE(incise(a, context(), across, 5, 90, 7, false, &cuts).ok());
    const BladeResult sheet =
        build_undermining(context(), std::vector<Vec2>{{-14, -9}, {14, -9}, {14, 9}, {-14, 9}}, kBed_mm);
    EXPECT_TRUE(sheet.blade) << sheet.reason;
    EXPECT_TRUE(a.cut(*sheet.blade, 9).ok());
  }
  BladeResult through(const std::vector<Vec3>& on_bed, bool open = false, const Vec3& out = Vec3::UnitZ()) {
    std::vector<Vec3> seen;
    for (const Vec3& X : on_bed) seen.push_back(skin.nearest(X).X_mm);
    std::string reason;
    view = *view_of(skin, seen, reason);
    BladeContext c = context();
    c.view = &view;
    c.skin = [this](const ChartPoint& p) { return skin.at(p, view); };
    return build_through(c, skin, {std::vector<Vec3>(on_bed.size(), out), open, open, on_bed});
  }
  /// Area and highest place of the walls that stand across x near 0.
  std::pair<double, double> walls_across() const {
    double area = 0, top = -1e9;
    for (const Face& f : a.faces()) {
      if (!f.live() || f.mat != 3) continue;
      const Vec3 p = a.point_mm(f.v[0]), q = a.point_mm(f.v[1]), r = a.point_mm(f.v[2]);
      const Vec3 n = 0.5 * (q - p).cross(r - p);
      if (n.norm() < 1e-9 || std::abs(n.x()) < 0.9 * n.norm() || std::abs(p.x()) > 1) continue;
      area += n.norm(), top = std::max({top, p.z(), q.z(), r.z()});
    }
    return {area, top};
  }
};

TEST(FromBed, PartsWhatLiesBelowAndLeavesTheFlapWhole) {
  Pocketed s;
  const double before = s.a.volume_mm3();
  const BladeResult b = s.through({{0, -6, -kBed_mm}, {0, 6, -kBed_mm}});
  ASSERT_TRUE(b.blade) << b.reason;
  ASSERT_TRUE(s.a.cut(*b.blade, 11).ok());
  EXPECT_EQ(s.a.check_all(), "");
  const auto [area, top] = s.walls_across();
  // 12 mm long, from the bed (kSheetRaise above the depth asked) to the other side; the grid's rounding.
  EXPECT_NEAR(area, 12 * (kThick_mm - kBed_mm + kSheetRaise), 0.5);
  EXPECT_NEAR(top, -(kBed_mm - kSheetRaise), 0.05) << "nothing of it above the bed";
  EXPECT_NEAR(s.a.volume_mm3(), before, 1e-9 * before);
  EXPECT_EQ(s.a.pieces(), 1);
}

TEST(FromBed, GoesOnOverFreeMarginsBelowTheFlap) {
  Pocketed s;
  const BladeResult b = s.through({{0, -8, -kBed_mm}, {0, 8, -kBed_mm}}, true);
  ASSERT_TRUE(b.blade) << b.reason;
  ASSERT_TRUE(s.a.cut(*b.blade, 11).ok());
  EXPECT_EQ(s.a.check_all(), "");
  const auto [area, top] = s.walls_across();
  // All 24 mm of its width, from the bed down; beyond the last posts, 8 mm from the middle, it dips to .3 mm below it.
  const double all = 24 * (kThick_mm - kBed_mm + kSheetRaise);
  EXPECT_LT(area, all);
  EXPECT_GT(area, all - 2 * 4 * 0.3);
  EXPECT_NEAR(top, -(kBed_mm - kSheetRaise), 0.05) << "nothing of it above the bed";
}

// The blade leans by 50 degrees; its places lie up to 2 mm off the bed.
TEST(FromBed, ABladeMayLeanAgainstTheBed) {
  Pocketed s;
  const double lean = 50 * M_PI / 180;
  const BladeResult b =
      s.through({{-3, -6, -kBed_mm + 1}, {-5, 6, -kBed_mm - 2}}, false, Vec3(std::sin(lean), 0, std::cos(lean)));
  ASSERT_TRUE(b.blade) << b.reason;
  const double before = s.a.volume_mm3();
  ASSERT_TRUE(s.a.cut(*b.blade, 11).ok());
  EXPECT_EQ(s.a.check_all(), "");
  EXPECT_NEAR(s.a.volume_mm3(), before, 1e-9 * before);
  double area = 0;
  for (const Face& f : s.a.faces()) {
    if (!f.live() || f.mat != 3) continue;
    const Vec3 p = s.a.point_mm(f.v[0]), q = s.a.point_mm(f.v[1]), r = s.a.point_mm(f.v[2]);
    const Vec3 n = 0.5 * (q - p).cross(r - p);
    if (n.norm() > 1e-9 && std::abs(std::abs(n.x()) / n.norm() - std::cos(lean)) < 0.05) area += n.norm();
  }
  // As long as its places are apart on the bed, and as deep as the slab is along it.
  const double up = 1 * std::tan(lean), down = 2 * std::tan(lean), length = std::hypot(12, -2 + up + down);
  EXPECT_NEAR(area, length * (kThick_mm - kBed_mm + kSheetRaise) / std::cos(lean), 0.06 * area);
}

// The pocket ends 3 mm before the margin, the last post lies between: the blade goes on from where there is a bed.
TEST(FromBed, GoesOnOverAMarginThatThePocketEndsBefore) {
  Pocketed s;
  const BladeResult b = s.through({{0, -10.5, -kBed_mm}, {0, 10.5, -kBed_mm}}, true);
  ASSERT_TRUE(b.blade) << b.reason;
  ASSERT_TRUE(s.a.cut(*b.blade, 11).ok());
  EXPECT_EQ(s.a.check_all(), "");
  const double all = 24 * (kThick_mm - kBed_mm + kSheetRaise);
  EXPECT_GT(s.walls_across().first, all - 2 * 4 * 0.3);
  Pocketed far;
  EXPECT_FALSE(far.through({{0, -6, -kBed_mm}, {0, 14, -kBed_mm}}, true).blade) << "farther off than 3 mm";
}

TEST(FromBed, WithoutABedItIsRefusedInWords) {
  Pocketed s;
  const BladeResult b = s.through({{22, -6, -kBed_mm}, {22, 6, -kBed_mm}});
  EXPECT_FALSE(b.blade);
  EXPECT_NE(b.reason.find("there is no bed within 3 mm"), std::string::npos) << b.reason;
}

}  // namespace test_from_bed
}  // namespace limberg
