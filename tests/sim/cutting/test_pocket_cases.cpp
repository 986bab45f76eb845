// Named cases at the level of strokes: pockets that meet incisions and one another, flaps cut without their bed, plugs
// without a floor, cuts across holes.
#include "sim/cutting/arrangement/handles.h"
#include "tests/sim/cutting/patient.h"

namespace limberg::test {
namespace test_pocket_cases {

std::vector<Vec2> box(double x0, double y0, double x1, double y1) { return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}; }

/// Live walls across the vertical through a point of the chart, as heights, from above down.
std::vector<double> walls_below(const Patient& p, const Vec2& q) {
  std::vector<double> z;
  for (const Face& f : p.a.faces()) {
    if (!f.live() || f.mat != 3) continue;
    const Vec3 a = p.a.point_mm(f.v[0]), b = p.a.point_mm(f.v[1]), c = p.a.point_mm(f.v[2]);
    const std::vector<Vec2> t{a.head<2>(), b.head<2>(), c.head<2>()};
    if (std::abs(signed_area(t)) > 1e-6 && inside_polygon(t, q)) z.push_back(a.z());
  }
  std::sort(z.rbegin(), z.rend());
  return z;
}

TEST(PocketCases, Case29_MeetsTheIncisionExactlyShortOrPast) {
  // The outline's long edge on the incision's line, short of it and past it: one ball, and the flap's edge is free.
  for (const double gap : {-1.4, -0.6, -0.1, 0.0, 0.1, 0.6, 1.2}) {
    SCOPED_TRACE(gap);
    Patient p(2);
    ASSERT_TRUE(p.incise({{-20, 0.3}, {20, 0.3}}).ok());
    const CutResult r = p.undermine(box(-15, 0.3 - gap, 15, 15));
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(euler(p.a), Chi{2});
    EXPECT_EQ(walls_below(p, {0.2, 0.9}).size(), 1u);
    EXPECT_EQ(walls_below(p, {0.2, -0.8}).size(), 0u);  // nothing beyond the wall (case 30)
  }
  // A pocket that only points at the incision.
  for (const double gap : {-0.4, 0.0, 0.3, 0.45}) {
    SCOPED_TRACE(gap);
    Patient p(2);
    ASSERT_TRUE(p.incise({{-20, 0.3}, {20, 0.3}}).ok());
    const CutResult r = p.undermine({{0, 0.3 + gap}, {9, 14}, {-8, 15}});
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(euler(p.a), Chi{2});
    EXPECT_EQ(walls_below(p, {0.3, 8}).size(), 1u);
  }
  // One that is out of reach meets nothing.
  Patient p(2);
  ASSERT_TRUE(p.incise({{-20, 0.3}, {20, 0.3}}).ok());
  const uint64_t hash = p.a.full_hash();
  const CutResult r = p.undermine(box(-15, 4, 15, 15));
  EXPECT_EQ(r.status, CutResult::refused);
  EXPECT_NE(r.reason.find("cut the skin first"), std::string::npos);
  EXPECT_EQ(p.a.full_hash(), hash);
}

TEST(PocketCases, ExactlyThroughTheTipsOfFlaps) {
  // Both flaps of a Z-plasty under one sheet whose border runs through the tips: no bridge is left there.
  const Vec2 a(-10, 0), b(10, 0), arm(10, 10 * std::sqrt(3.0));
  for (const double off : {-0.3, 0.0, 0.3})
    for (const bool at_once : {true, false}) {
      SCOPED_TRACE(testing::Message() << "off by " << off << (at_once ? ", one stroke" : ", three strokes"));
      Patient p(2);
      if (at_once) {
        ASSERT_TRUE(p.incise({a + arm, a, b, b - arm}).ok());
      } else {
        for (const std::vector<Vec2>& path :
             {std::vector<Vec2>{a, b}, std::vector<Vec2>{a, a + arm}, std::vector<Vec2>{b, b - arm}})
          ASSERT_TRUE(p.incise(path).ok());
      }
      const Vec2 d(off, -off);
      const CutResult r = p.undermine({a + arm + d, a - d, b - arm - d, b + d});
      ASSERT_TRUE(r.ok()) << r.reason;
      EXPECT_EQ(p.a.pieces(), 1);
      EXPECT_EQ(euler(p.a), Chi{2});
      while (p.a.undo()) {
      }
    }
}

TEST(PocketCases, Case31_TwoPocketsThatMerge) {
  // From two parallel incisions towards each other: the skin between them becomes a bridge, one handle. Overlapping
  // much, little, just touching, and short of each other by what a hand misses.
  for (const double overlap : {8.0, 4.0, 3.0, 2.0, 1.4, 1.0, 0.5, 0.0, -0.4, -0.8}) {
    SCOPED_TRACE(overlap);
    Patient p(2);
    ASSERT_TRUE(p.incise({{-22, -12}, {22, -12}}).ok());
    ASSERT_TRUE(p.incise({{-22, 12}, {22, 12}}).ok());
    ASSERT_TRUE(p.undermine(box(-17, -12, 17, overlap / 2)).ok());
    EXPECT_EQ(euler(p.a), Chi{2});
    const CutResult r = p.undermine(box(-15, -overlap / 2, 15, 12));
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(p.a.pieces(), 1);
    EXPECT_EQ(euler(p.a), Chi{0});
    for (double x = -14; x < 14; x += 0.7)
      for (double y = -10; y < 11; y += 0.7) EXPECT_GE(walls_below(p, {x, y}).size(), 1u) << x << " " << y;
    while (p.a.undo()) ASSERT_EQ(p.a.check_all(), "");
  }
}

TEST(PocketCases, TheShelfOfMergedPocketsIsThinAndNarrow) {
  // Where the second sheet runs over the first before it dips into it, tissue is left between the two: no thicker than
  // the sheets' own distance and what they stay apart (0.2), and no wider than one width of the sheet's mesh.
  for (const double overlap : {8.0, 2.0, 0.0, -0.6})
    for (const double second : {4.0, 3.6}) {
      SCOPED_TRACE(testing::Message() << "overlap " << overlap << ", second at " << second);
      Patient p(2);
      ASSERT_TRUE(p.incise({{-22, -12}, {22, -12}}, 4.5).ok());
      ASSERT_TRUE(p.incise({{-22, 12}, {22, 12}}, 4.5).ok());
      ASSERT_TRUE(p.undermine(box(-17, -12, 17, overlap / 2), 4).ok());
      ASSERT_TRUE(p.undermine(box(-15, -overlap / 2, 15, 12), second).ok());
      EXPECT_EQ(euler(p.a), Chi{0});  // the bridge of skin, and nothing between the sheets
      constexpr double step = 0.2;
      for (double x = -13; x < 13; x += 1.3) {
        int shelf = 0;
        for (double y = -7; y < 7; y += step) {
          const std::vector<double> z = walls_below(p, {x, y + 1e-3});
          ASSERT_GE(z.size(), 1u) << x << " " << y;
          ASSERT_LE(z.size(), 2u) << x << " " << y;
          if (z.size() == 1) continue;
          ++shelf;
          EXPECT_LT(z[0] - z[1], 0.2 + std::abs(4 - second)) << x << " " << y;
        }
        EXPECT_LE(shelf * step, kSheetSpacing) << x;
      }
    }
}

TEST(PocketCases, PocketsThatAreWiderThanTheirMouth) {
  // Blind pockets: round about a short incision, beyond its end, to one side of it, as a tunnel. All of the outline is
  // undermined, the pocket opens into the incision alone, and no bridge of tissue stays in its mouth: one ball.
  const auto ellipse = [](const Vec2& middle, double a, double b) {
    std::vector<Vec2> out;
    for (int i = 0; i < 24; ++i) out.push_back(middle + Vec2(a * std::cos(i * M_PI / 12), b * std::sin(i * M_PI / 12)));
    return out;
  };
  struct Case {
    const char* name;
    std::vector<Vec2> incision, outline;
  };
  const std::vector<Vec2> mouth{{-6, 0.2}, {6, 0.2}};
  for (const Case& c : std::vector<Case>{{"round about", mouth, ellipse({0, 0}, 13, 12)},
                                         {"round about a bend", {{-6, 3}, {0, 0}, {6, 3}}, ellipse({0, 1}, 14, 13)},
                                         {"beyond one end", mouth, ellipse({10, 0}, 9, 6)},
                                         {"to one side", mouth, box(-15, 0.2, 15, 14)},
                                         {"to one side, a little past it", mouth, box(-15, -0.1, 15, 14)},
                                         {"to one side, a little short of it", mouth, box(-15, 0.5, 15, 14)},
                                         {"to the other side", mouth, box(-15, -14, 15, 0.2)},
                                         {"to one side, beyond one end", {{-20, 0.2}, {3, 0.2}}, box(-9, 0.2, 25, 14)},
                                         {"to one side, aslant", {{-6, 0.5}, {6, -0.3}}, box(-15, 0.2, 15, 14)},
                                         {"a tunnel from the end", mouth, box(5.8, -2, 25, 2.5)},
                                         {"a tunnel from the side", mouth, box(-1.5, 0.2, 1.5, 20)}}) {
    SCOPED_TRACE(c.name);
    Patient p(2);
    ASSERT_TRUE(p.incise(c.incision).ok());
    const CutResult r = p.undermine(c.outline);
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(p.a.pieces(), 1);
    EXPECT_EQ(euler(p.a), Chi{2});
    EXPECT_EQ(euler_characteristic(p.a), 2);
    for (double x = -24; x < 26; x += 1.63)
      for (double y = -14; y < 21; y += 1.59) {
        bool well_inside = true;
        for (int k = 0; k < 8; ++k)
          well_inside = well_inside && inside_polygon(c.outline, Vec2(x, y) + 0.9 * Vec2(std::cos(k * M_PI / 4),
                                                                                         std::sin(k * M_PI / 4)));
        if (well_inside) {
          EXPECT_EQ(walls_below(p, {x, y}).size(), 1u) << x << " " << y;
        }
      }
    ASSERT_TRUE(p.a.undo());
    EXPECT_EQ(p.a.check_all(), "");
  }
  // Under two incisions at once: a bridge of skin between two mouths, one handle.
  Patient p(2);
  ASSERT_TRUE(p.incise(mouth).ok());
  ASSERT_TRUE(p.incise({{-3, 5}, {3, 5}}).ok());
  ASSERT_TRUE(p.undermine(ellipse({0, 0}, 20, 12)).ok());
  EXPECT_EQ(euler(p.a), Chi{0});
  EXPECT_EQ(euler_characteristic(p.a), 0);
}

TEST(PocketCases, ADeeperSecondPocket) {
  Patient p(2);
  ASSERT_TRUE(p.incise({{-20, 0}, {20, 0}}, 3).ok());
  ASSERT_TRUE(p.undermine(box(-15, 0, 15, 14), 3).ok());
  // Deeper than the incision: out of reach until the incision is deepened.
  EXPECT_EQ(p.undermine(box(-13, 0, 13, 12), 6).status, CutResult::refused);
  ASSERT_TRUE(p.incise({{-20, 0}, {20, 0}}, 6).ok());
  EXPECT_EQ(euler(p.a), Chi{2});
  ASSERT_TRUE(p.undermine(box(-13, 0, 13, 12), 6).ok());
  EXPECT_EQ(euler(p.a), Chi{2});
  EXPECT_EQ(p.a.pieces(), 1);
  const std::vector<double> z = walls_below(p, {1.1, 6.3});
  ASSERT_EQ(z.size(), 2u);
  EXPECT_NEAR(z[0], -2.85, 0.15);
  EXPECT_NEAR(z[1], -5.85, 0.15);
}

TEST(PocketCases, Case32_AFlapIsCutWithoutItsBed) {
  Patient p(2);
  ASSERT_TRUE(p.incise({{-20, 0}, {20, 0}}).ok());
  ASSERT_TRUE(p.undermine(box(-18, 0, 18, 18)).ok());
  const std::vector<int32_t> before = p.live_walls();
  // Across the flap, deeper than it is thick: from its free edge, and wholly within it.
  for (const std::vector<Vec2>& path : {std::vector<Vec2>{{3, 0}, {4, 12}}, std::vector<Vec2>{{-10, 5}, {-5, 11}}}) {
    const CutResult r = p.incise(path, 6);
    ASSERT_TRUE(r.ok()) << r.reason;
    for (int32_t f : p.a.last_operation().new_walls)
      for (int32_t v : p.a.faces()[f].v) EXPECT_GT(p.a.point_mm(v).z(), -4.1);
  }
  EXPECT_EQ(euler(p.a), Chi{0});  // the second is a slit through the flap: one handle
  // Deepening it would cut the bed: it ends on the pocket and has no front there.
  EXPECT_EQ(p.incise({{-10, 5}, {-5, 11}}, 8).status, CutResult::nothing_to_cut);
}

TEST(PocketCases, Case33_StackedPieces) {
  // A plug cut free but left in place over its bed: a stroke on it spares the bed, one across plug
  // and skin cuts both.
  Patient p(2);
  ASSERT_TRUE(p.cut(build_plug(p.context(), std::vector<Vec2>{{9, 0}, {0, 8}, {-9, 0}, {0, -8}}, 4)).ok());
  ASSERT_EQ(p.a.pieces(), 2);
  ASSERT_TRUE(p.incise({{-5, 2}, {5, 2}}, 6).ok());  // within the plug, deeper than it
  for (int32_t f : p.a.last_operation().new_walls)
    for (int32_t v : p.a.faces()[f].v) EXPECT_GT(p.a.point_mm(v).z(), -4.01);
  EXPECT_EQ(p.a.pieces(), 2);
  ASSERT_TRUE(p.incise({{-18, -1}, {18, -1.5}}, 4).ok());  // across both
  EXPECT_EQ(p.a.pieces(), 3);                              // the plug is parted, the rest is one
  EXPECT_TRUE(p.a.undo());
  EXPECT_EQ(p.a.pieces(), 2);
}

TEST(PocketCases, Case36_AcrossAHole) {
  Patient p(2);
  ASSERT_TRUE(p.cut(build_plug(p.context(), std::vector<Vec2>{{7, 0}, {0, 6}, {-7, 0}, {0, -6}}, 4)).ok());
  ASSERT_TRUE(p.a.excise(p.a.loose_component_near({0, 0, -2}, 5)).done);
  for (const double depth : {3.0, 6.0}) {
    const CutResult r = p.incise({{-18, 0.4}, {18, -0.3}}, depth);
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(euler(p.a), Chi{2});
    bool left = false, right = false;
    for (int32_t f : p.a.last_operation().new_walls) {
      const Face& t = p.a.faces()[f];
      const Vec3 c = (p.a.point_mm(t.v[0]) + p.a.point_mm(t.v[1]) + p.a.point_mm(t.v[2])) / 3;
      left = left || c.x() < -7, right = right || c.x() > 7;
      if (std::abs(c.x()) < 6) {
        EXPECT_LT(c.z(), -3.9);  // no wall in the void
      }
    }
    EXPECT_TRUE(left && right);
  }
}

TEST(PocketCases, Case4_APlugWithoutFloorIsFreedByUndermining) {
  for (const double beyond : {-0.3, 0.0, 0.4, 6.0}) {
    SCOPED_TRACE(beyond);
    Patient p(2);
    const double v = p.a.volume_mm3();
    std::vector<Vec2> ring;
    for (int i = 0; i < 20; ++i) ring.push_back(9.0 * Vec2(std::cos(i * M_PI / 10), std::sin(i * M_PI / 10)));
    std::vector<Vec2> closed = ring;
    closed.push_back(ring[0]);
    ASSERT_TRUE(p.incise(closed).ok());
    EXPECT_EQ(p.a.pieces(), 1);
    std::vector<Vec2> outline;
    for (const Vec2& q : ring) outline.push_back(q * ((9 + beyond) / 9));
    const CutResult r = p.undermine(outline);
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(p.a.pieces(), 2);
    const ExciseResult e = p.a.excise(p.a.loose_component_near({0, 0, -1}, 5));
    ASSERT_TRUE(e.done);
    // The sheet lies 0.15 to 0.23 mm above the depth asked (blade_build.h).
    EXPECT_NEAR(e.volume_mm3, 3.81 * std::abs(signed_area(ring)), 0.045 * std::abs(signed_area(ring)));
    EXPECT_NEAR(p.a.volume_mm3() + e.volume_mm3, v, 1e-9 * v);
    EXPECT_EQ(p.a.check_all(), "");
    EXPECT_EQ(euler(p.a), Chi{2});
  }
}

}  // namespace test_pocket_cases
}  // namespace limberg::test
