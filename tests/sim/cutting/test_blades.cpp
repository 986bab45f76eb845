// Blades from strokes on the generated block: the whole rhomboid sequence, also with a shaking hand, and T-junctions.
#include <gtest/gtest.h>

#include <random>

#include "sim/cutting/strokes/sheet_mesh.h"
#include "tests/sim/cutting/patient.h"

namespace limberg::test {
namespace test_blades {

struct Rhomboid {
  std::vector<Vec2> rhombus{{17.32, 0}, {0, 10}, {-17.32, 0}, {0, -10}};
  std::vector<Vec2> flap{{0, 10}, {0, 30}, {17.32, 20}};
  std::vector<Vec2> under{{0, 10}, {0, 30}, {17.32, 20}, {17.32, 0}};
};

// A drawn line: points every 0.3 mm with noise, and a pause at both ends.
std::vector<Vec2> drawn(const std::vector<Vec2>& corners, double noise, std::mt19937& random, bool closed) {
  std::normal_distribution<double> n(0, noise);
  std::vector<Vec2> out;
  std::vector<Vec2> c = corners;
  if (closed) c.push_back(corners[0]);
  const Vec2 offset(n(random) * 1.5, n(random) * 1.5);
  for (int i = 0; i < 8; ++i) out.push_back(c[0] + offset + 0.2 * Vec2(n(random), n(random)));
  for (size_t i = 0; i + 1 < c.size(); ++i) {
    const int k = int((c[i + 1] - c[i]).norm() / 0.3);
    for (int j = 0; j < k; ++j)
      out.push_back(c[i] + offset + (c[i + 1] - c[i]) * (double(j) / k) + 0.2 * Vec2(n(random), n(random)));
  }
  for (int i = 0; i < 8; ++i) out.push_back(c.back() + offset + 0.2 * Vec2(n(random), n(random)));
  return out;
}

void run_rhomboid(Patient& p, const std::vector<Vec2>& rhombus, const std::vector<Vec2>& flap,
                  const std::vector<Vec2>& under, double tolerance) {
  const double before = p.a.volume_mm3();
  const uint64_t hash = p.a.hash();
  CutResult r = p.cut(build_plug(p.context(), rhombus, 4));
  ASSERT_TRUE(r.ok()) << r.reason;
  ASSERT_EQ(p.a.pieces(), 2);
  const ExciseResult e = p.a.excise(p.a.loose_component_near({0, 0, -2}, 10));
  ASSERT_TRUE(e.done);
  EXPECT_NEAR(e.volume_mm3, 4 * std::abs(signed_area(rhombus)), tolerance * e.volume_mm3);
  ASSERT_EQ(p.a.check_all(), "");
  EXPECT_EQ(euler(p.a), Chi{2});
  r = p.incise(flap, 4);
  ASSERT_TRUE(r.ok()) << r.reason;
  EXPECT_EQ(euler(p.a), Chi{2});
  r = p.cut(build_undermining(p.context(), under, 4));
  ASSERT_TRUE(r.ok()) << r.reason;
  // One piece and still a ball: the flap hangs on its pedicle only, nothing is bridged underneath.
  EXPECT_EQ(p.a.pieces(), 1);
  EXPECT_EQ(euler(p.a), Chi{2});
  EXPECT_NEAR(p.a.volume_mm3() + e.volume_mm3, before, 1e-9 * before);
  while (p.a.undo()) ASSERT_EQ(p.a.check_all(), "");
  EXPECT_EQ(p.a.hash(), hash);
}

TEST(Blades, RhomboidFromAScript) {
  Patient p;
  const Rhomboid g;
  run_rhomboid(p, g.rhombus, g.flap, g.under, 1e-3);
}

TEST(Blades, RhomboidWithAShakingHand) {
  Patient p(2);
  const Rhomboid g;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    run_rhomboid(p, drawn(g.rhombus, 0.12, random, true), drawn(g.flap, 0.12, random, false),
                 drawn(g.under, 0.12, random, true), 0.05);
  }
}

TEST(Blades, RhomboidUnderminedAllAround) {
  Patient p(2);
  const Rhomboid g;
  for (double radius : {26.0, 30.5}) {
    std::vector<Vec2> disc;
    for (int i = 0; i < 24; ++i)
      disc.push_back(Vec2(6, 12) + radius * Vec2(std::cos(i * M_PI / 12), std::sin(i * M_PI / 12)));
    run_rhomboid(p, g.rhombus, g.flap, disc, 1e-3);
  }
}

TEST(Blades, FlapStartsShortOfOrPastTheCorner) {
  Patient p;
  const Rhomboid g;
  for (const Vec2& off : {Vec2(0, 0), Vec2(0, 0.45), Vec2(0.3, 0.3), Vec2(-0.3, 0.2), Vec2(0, -0.5), Vec2(0, -3),
                          Vec2(0.45, 0), Vec2(-0.01, 0.02)}) {
    SCOPED_TRACE(off.transpose());
    std::vector<Vec2> flap = g.flap;
    flap[0] += off;
    run_rhomboid(p, g.rhombus, flap, g.under, 1e-3);
  }
}

TEST(Blades, TJunctionsJoin) {
  // An incision that ends on an earlier one: undermining the corner between them frees it all the way (one handle less
  // than when a bridge is left).
  for (double gap : {-0.4, -0.1, 0.0, 0.1, 0.4}) {
    SCOPED_TRACE(gap);
    Patient p(2);
    ASSERT_TRUE(p.incise({{-20, 0}, {20, 0}}, 5).ok());
    ASSERT_TRUE(p.incise({{0, 20}, {0, gap}}, 5).ok());
    const CutResult r = p.cut(build_undermining(p.context(), std::vector<Vec2>{{0, 0}, {12, 0}, {0, 14}}, 5));
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(euler(p.a), Chi{2});
  }
}

TEST(Blades, ZPlastyCorners) {
  for (double angle : {30.0, 45.0, 60.0, 90.0}) {
    SCOPED_TRACE(angle);
    Patient p(2);
    const double t = angle * M_PI / 180, l = 15;
    const Vec2 a(-l / 2, 0), b(l / 2, 0);
    ASSERT_TRUE(p.incise({a, b}, 4).ok());
    const Vec2 c = a + l * Vec2(std::cos(t), std::sin(t)), d = b - l * Vec2(std::cos(t), std::sin(t));
    CutResult r = p.incise({a, c}, 4);
    ASSERT_TRUE(r.ok()) << r.reason;
    r = p.incise({b, d}, 4);
    ASSERT_TRUE(r.ok()) << r.reason;
    r = p.cut(build_undermining(p.context(), std::vector<Vec2>{a, b, c}, 4));
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(euler(p.a), Chi{2});
    r = p.cut(build_undermining(p.context(), std::vector<Vec2>{a, d, b}, 4));
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(p.a.pieces(), 1);  // the two sheets may leave a lamella where they overlap, so no word about handles
  }
}

TEST(Blades, OverlappingUnderminingsAreOnePocket) {
  const std::vector<Vec2> first{{-20, 0}, {20, 0}, {20, 14}, {-20, 14}};
  for (const std::vector<Vec2>& second : {std::vector<Vec2>{{-18, 7}, {18, 7}, {18, 28}, {-18, 28}},   // further on
                                          std::vector<Vec2>{{0, -1}, {32, -1}, {32, 20}, {0, 20}}}) {  // to the side
    Patient p(2);
    ASSERT_TRUE(p.incise({{-25, 0}, {36, 0}}, 4).ok());
    ASSERT_TRUE(p.cut(build_undermining(p.context(), first, 4)).ok());
    const int before = int(p.a.last_operation().new_walls.size());
    const CutResult r = p.cut(build_undermining(p.context(), second, 4));
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_GT(before, 100);
    EXPECT_EQ(p.a.pieces(), 1);
    for (const SurfaceComponent& c : p.a.components()) EXPECT_GT(c.volume_mm3, 1);
    // One pocket: under every point of the union's inside there is a wall, under the overlap's inside only one.
    for (int i = 0; i < 200; ++i) {
      const Vec2 q(-22 + 54 * ((i * 37) % 200) / 200.0, 1 + 26 * ((i * 61) % 200) / 200.0);
      const auto margin = [&](const std::vector<Vec2>& outline) {
        double d = 1e9;
        for (size_t k = 0; k < 4; ++k) d = std::min(d, distance_to_segment(q, outline[k], outline[(k + 1) % 4]));
        return inside_polygon(outline, q) ? d : -d;
      };
      if (std::max(margin(first), margin(second)) < 0.3) continue;
      std::vector<double> z;
      for (const Face& f : p.a.faces()) {
        if (!f.live() || f.mat != 3) continue;
        const Vec3 a = p.a.point_mm(f.v[0]), b = p.a.point_mm(f.v[1]), c = p.a.point_mm(f.v[2]);
        const std::vector<Vec2> t{a.head<2>(), b.head<2>(), c.head<2>()};
        if (std::abs(signed_area(t)) > 1e-6 && inside_polygon(t, q)) z.push_back(a.z());
      }
      EXPECT_GE(z.size(), 1u) << q.transpose();
      if (std::min(margin(first), margin(second)) > 5.5) {
        EXPECT_EQ(z.size(), 1u) << q.transpose();
      }
    }
    const BladeResult again =
        build_undermining(p.context(), std::vector<Vec2>{{-10, 4}, {10, 4}, {10, 10}, {-10, 10}}, 4);
    EXPECT_FALSE(again.blade);
    EXPECT_EQ(again.reason, "this is undermined already");
  }
}

TEST(Blades, SlantedAndSharp) {
  for (double angle : {45.0, 60.0, 90.0, 120.0, 135.0}) {
    Patient p(2);
    const CutResult r = p.incise({{-15, 0}, {0, 1}, {-10, 8}}, 4, angle);
    ASSERT_TRUE(r.ok()) << angle << r.reason;
    EXPECT_EQ(euler(p.a), Chi{2});
  }
}

TEST(Blades, ClosedLoopWithoutFloorKeepsThePost) {
  Patient p(2);
  ASSERT_TRUE(p.incise({{10, 0}, {0, 8}, {-10, 0}, {0, -8}, {10, 0}}, 4).ok());
  EXPECT_EQ(p.a.pieces(), 1);
  EXPECT_EQ(euler(p.a), Chi{2});
}

TEST(Blades, BadStrokesAreRefused) {
  Patient p(4);
  const uint64_t hash = p.a.full_hash();
  const double nan = std::nan("");
  const auto incise = [&](std::vector<Vec2> path, double depth = 4, double angle = 90) {
    const CutResult r = p.incise(path, depth, angle);
    EXPECT_FALSE(r.ok());
    EXPECT_FALSE(r.reason.empty());
  };
  incise({});
  incise({{0, 0}});
  incise({{0, 0}, {0, 0}});
  incise({{0, 0}, {nan, 3}});
  incise({{0, 0}, {10, 0}}, -1);
  incise({{0, 0}, {10, 0}}, nan);
  incise({{0, 0}, {10, 0}}, 4, 0);
  incise({{40, 0}, {80, 0}});  // off the skin
  EXPECT_FALSE(build_plug(p.context(), std::vector<Vec2>{{0, 0}, {5, 0}}, 4).blade);
  EXPECT_FALSE(build_plug(p.context(), std::vector<Vec2>{{0, 0}, {5, 0}, {0, 5}, {5, 5}}, 4).blade);
  const BladeResult sheet = build_undermining(p.context(), std::vector<Vec2>{{0, 0}, {9, 0}, {0, 9}}, 4);
  ASSERT_TRUE(sheet.blade);
  const CutResult r = p.a.cut(*sheet.blade, 1);  // nothing to undermine from
  EXPECT_EQ(r.status, CutResult::refused);
  EXPECT_EQ(p.a.full_hash(), hash);
}

TEST(SheetMesh, CoversThePolygonEvenly) {
  const std::vector<Vec2> corners{{0, 0}, {20, 0}, {20, 10}, {10, 4}, {0, 12}};
  const std::vector<Vec2> polygon = resample(corners, 2, true);
  const auto mesh = mesh_polygon(polygon, 2);
  ASSERT_TRUE(mesh);
  double area = 0, longest = 0;
  for (const Tri& t : mesh->tri) {
    const std::vector<Vec2> p{mesh->vertex[size_t(t[0])], mesh->vertex[size_t(t[1])], mesh->vertex[size_t(t[2])]};
    EXPECT_GT(signed_area(p), 0);
    area += signed_area(p);
    for (size_t k = 0; k < 3; ++k) longest = std::max(longest, (p[k] - p[(k + 1) % 3]).norm());
  }
  EXPECT_NEAR(area, signed_area(polygon), 1e-9);
  EXPECT_LT(longest, 2 * 2.0);
}

}  // namespace test_blades
}  // namespace limberg::test
