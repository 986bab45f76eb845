// Blades of planes that meet in a corner: steps and splits through solid bone and shells, against volumes by hand.
#include <gtest/gtest.h>

#include <numbers>

#include "sim/skull/bone/corner_blade.h"
#include "sim/skull/bone/osteotomy.h"
#include "sim/skull/bone/surface.h"
#include "tests/sim/skull/bone/shapes.h"

namespace limberg::bone {
namespace test_corner_blade {

using simplex::Mesh;

const Vec3 kX = Vec3::UnitX(), kY = Vec3::UnitY(), kZ = Vec3::UnitZ();

std::vector<double> volumes_of(const Mesh& m) {
  std::vector<int32_t> of;
  const int32_t n = simplex::components(m, of);
  std::vector<double> out;
  for (const Bulk& b : bulks(m, of, n)) out.push_back(b.volume_mm3);
  std::sort(out.begin(), out.end());
  return out;
}

Osteotomy fan(const Vec3& corner, std::vector<Vec3> rays, double reach_mm) {
  Osteotomy o;
  o.kind = Osteotomy::Kind::fan, o.point_mm = corner, o.ray = std::move(rays), o.radius_mm = reach_mm;
  return o;
}

/// Closed parts whose walls are the same polygons on both sides and lie on the blade.
void expect_sound(const Mesh& m, const Cut& cut, const Osteotomy& o, double off_blade_mm) {
  EXPECT_EQ(simplex::find_fault(m).value_or(""), "");
  EXPECT_EQ(simplex::census(m).end_contours, 0);
  ASSERT_EQ(cut.wall_left.size(), cut.wall_right.size());
  const CornerBlade blade(o.point_mm, o.ray, o.radius_mm);
  for (size_t i = 0; i < cut.wall_left.size(); ++i) {
    const simplex::FaceArea a = simplex::face_area(m, cut.wall_left[i]), b = simplex::face_area(m, cut.wall_right[i]);
    EXPECT_LT((a.vector_mm2 + b.vector_mm2).norm(), 1e-9);
    // Flat: the fan's area is that of its outline, but for places where the curve is led round a vertex (section.h): at
    // most 6.9 % here, and 13 and 27 % where the walls do not fold (2026-11-27).
    EXPECT_LT(a.area_mm2, a.vector_mm2.norm() * 1.1);
    for (const int32_t v : m.ring(cut.wall_left[i])) {
      const Vec2 flat = blade.unrolled(m.x_mm[size_t(v)]);
      EXPECT_NEAR(flat.norm(), (m.x_mm[size_t(v)] - o.point_mm).norm(), off_blade_mm);
    }
  }
}

TEST(CornerBlade, UnrollsFlat) {
  const CornerBlade b({1, 2, 3}, {-kX, -kY, -kZ, kX}, 50);
  ASSERT_EQ(b.fault(), "");
  EXPECT_EQ(b.sectors(), 3u);
  // Along the rays: a quarter turn from each to the next.
  const Vec2 at[] = {{10, 0}, {0, 10}, {-10, 0}, {0, -10}};
  const Vec3 ray[] = {-kX, -kY, -kZ, kX};
  for (int i = 0; i < 4; ++i) EXPECT_LT((b.unrolled(Vec3(1, 2, 3) + 10 * ray[i]) - at[i]).norm(), 1e-9) << i;
  // A place over a sector lies there as its foot does, in that sector.
  EXPECT_EQ(b.sector(Vec3(1 - 5, 2 - 7, 3 + 0.1)), 0u);
  EXPECT_EQ(b.sector(Vec3(1 + 0.1, 2 - 7, 3 - 5)), 1u);
  EXPECT_EQ(b.sector(Vec3(1 + 5, 2 - 0.1, 3 - 7)), 2u);
  EXPECT_LT((b.unrolled(Vec3(1 - 5, 2 - 7, 3 + 0.1)) - Vec2(5, 7)).norm(), 1e-9);
}

TEST(CornerBlade, AStepTakesAQuarterOfABall) {
  const Vec3 half(30, 20, 15);
  Mesh m = test::ellipsoid(5, half);
  const Mesh before = m;
  const double whole = volumes_of(m)[0];
  const Osteotomy o = fan({-60, 0, 0}, {kY, kX, -kZ}, 120);
  simplex::Delta d;
  const Cut cut = cut_bone(m, 0, o, d);
  ASSERT_TRUE(cut) << cut.reason;
  EXPECT_EQ(cut.curves, 1);
  EXPECT_EQ(cut.wall_left.size(), 2u);  // folded once
  expect_sound(m, cut, o, 0.3);
  const std::vector<double> v = volumes_of(m);
  ASSERT_EQ(v.size(), 2u);
  const double ball = 4. / 3 * std::numbers::pi * half.prod();
  EXPECT_NEAR(v[0], ball / 4, 0.01 * ball / 4);  // the mesh has 0.3 % less than the ball
  EXPECT_NEAR(v[0] + v[1], whole, 2e-4 * whole);
  simplex::undo(m, d);
  EXPECT_EQ(simplex::hash(m), simplex::hash(before));
}

TEST(CornerBlade, ASagittalSplitFoldsTwice) {
  const Vec3 half(12, 30, 25);
  Mesh m = test::ellipsoid(5, half);
  const Mesh before = m;
  const double whole = volumes_of(m)[0];
  // The line across through the corner, (., 24, 18), passes the ellipsoid: (24 / 30)^2 + (18 / 25)^2 > 1.
  const Vec3 corner(2, 24, 18);
  Osteotomy o = fan(corner, {-kX, -kY, -kZ, kX}, 70);
  simplex::Delta d;
  const Cut cut = cut_bone(m, 0, o, d);
  ASSERT_TRUE(cut) << cut.reason;
  EXPECT_EQ(cut.wall_left.size(), 3u);
  expect_sound(m, cut, o, 0.3);
  const std::vector<double> v = volumes_of(m);
  ASSERT_EQ(v.size(), 2u);
  // Above the level plane, or on its side of the middle one, behind the upright one: counted in cubes of .5 mm.
  double counted = 0, all = 0;
  constexpr double h = 0.5;
  for (double x = -12; x < 12; x += h)
    for (double y = -30; y < 30; y += h)
      for (double z = -25; z < 25; z += h) {
        const Vec3 p(x + h / 2, y + h / 2, z + h / 2);
        if (p.cwiseQuotient(half).squaredNorm() > 1) continue;
        all += h * h * h;
        if (p.y() < corner.y() && (p.z() > corner.z() || p.x() > corner.x())) counted += h * h * h;
      }
  EXPECT_NEAR(v[0], std::min(counted, all - counted), 0.015 * v[0]);
  EXPECT_NEAR(v[0] + v[1], whole, 2e-4 * whole);
  simplex::undo(m, d);
  EXPECT_EQ(simplex::hash(m), simplex::hash(before));
}

TEST(CornerBlade, AStepThroughAShellCutsBothTables) {
  const Vec3 half(70, 85, 65);
  Mesh m = test::skull_shell(5, half, 6);
  const double whole = volumes_of(m)[0];
  const Osteotomy o = fan({-120, 10, 15}, {kY, kX, kZ}, 240);
  simplex::Delta d;
  const Cut cut = cut_bone(m, 0, o, d);
  ASSERT_TRUE(cut) << cut.reason;
  EXPECT_EQ(cut.curves, 2);
  EXPECT_EQ(simplex::find_fault(m).value_or(""), "");
  const std::vector<double> v = volumes_of(m);
  ASSERT_EQ(v.size(), 2u);
  EXPECT_NEAR(v[0] + v[1], whole, 5e-4 * whole);
  double counted = 0;
  const Vec3 inner = half - Vec3::Constant(6);
  for (double x = -70; x < 70; ++x)
    for (double y = 10; y < 85; ++y)
      for (double z = 15; z < 65; ++z) {
        const Vec3 p(x + 0.5, y + 0.5, z + 0.5);
        counted += p.cwiseQuotient(half).squaredNorm() < 1 && p.cwiseQuotient(inner).squaredNorm() > 1;
      }
  EXPECT_NEAR(v[0], counted, 0.03 * counted);
}

TEST(CornerBlade, PlanesThatCrossEachOtherAreRefused) {
  const auto fault = [](const std::vector<Vec3>& rays) { return CornerBlade(Vec3::Zero(), rays, 50).fault(); };
  // A step and a split are sound, and so is a plane that goes on as it was.
  EXPECT_EQ(fault({kY, kX, -kZ}), "");
  EXPECT_EQ(fault({kX, kY, -kZ, -kX}), "");
  EXPECT_EQ(fault({kX, kY, -kX}), "");
  // From the third plane's last direction through the middle of the first plane: by hand, the line that both have in
  // common is (1, 1, 0), between x and y, and between -z and (2, 2, 1).
  EXPECT_NE(fault({kX, kY, -kZ, Vec3(2, 2, 1)}).find("plane 3 of the blade crosses or touches plane 1"),
            std::string::npos);
  EXPECT_EQ(fault({kX, kY, -kZ, Vec3(2, -2, 1)}), "");  // past it
  // Back to where it began: they touch.
  EXPECT_NE(fault({kX, kY, kZ, kX}).find("crosses or touches"), std::string::npos);
  // Folded back upon itself, in one plane.
  EXPECT_NE(fault({kX, kY, Vec3(1, 0.2, 0)}).find("plane 2 of the blade crosses or touches plane 1"),
            std::string::npos);
  Mesh m = test::ellipsoid();
  const uint64_t before = simplex::hash(m);
  simplex::Delta d;
  EXPECT_FALSE(cut_bone(m, 0, fan({0, 0, 0}, {kX, kY, -kZ, Vec3(2, 2, 1)}, 240), d));
  EXPECT_EQ(simplex::hash(m), before);
}

TEST(CornerBlade, WhatIsNoBladeIsRefusedAndChangesNothing) {
  Mesh m = test::ellipsoid();
  const uint64_t before = simplex::hash(m);
  const auto refused = [&](const Osteotomy& o, const std::string& why) {
    simplex::Delta d;
    const Cut cut = cut_bone(m, 0, o, d);
    EXPECT_NE(cut.reason.find(why), std::string::npos) << cut.reason;
    EXPECT_EQ(simplex::hash(m), before);
    EXPECT_TRUE(d.empty());
  };
  refused(fan({0, 0, 0}, {kX}, 100), "two to eight directions");
  refused(fan({0, 0, 0}, {kX, kX}, 100), "less than 5 or more than 150 degrees");
  refused(fan({0, 0, 0}, {kX, -kX}, 100), "less than 5 or more than 150 degrees");
  refused(fan({0, 0, 0}, {kX, Vec3::Zero()}, 100), "no length");
  refused(fan({0, 0, 0}, {kX, kY}, 0), "length above 0");
  refused(fan({0, 0, 0}, {kX, kY, -kX, -kY, kX}, 100), "crosses or touches");  // a full turn comes back
  refused(fan({0, 0, 0}, {kX, kY}, 100), "ends within the bone");
  refused(fan({100, 0, 0}, {kX, kY}, 50), "does not meet the bone");
}

}  // namespace test_corner_blade
}  // namespace limberg::bone
