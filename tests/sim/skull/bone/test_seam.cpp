// The seam of a join, smoothed: against the surface that was there before the cut.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/skull/simplex/dual.h"
#include "tests/sim/skull/bone/heads.h"

namespace limberg::bone {
namespace test_seam {

constexpr double kRadius_mm = 40, kCut_mm = 13;

/// A ball, a cap sawn off and turned about its own axis: the ball is what was there and what shall be there.
test::KeptBones turned_cap(double deg) {
  std::vector<NamedMesh> all;
  all.push_back({"ball", test::ellipsoid(4, Vec3::Constant(kRadius_mm)), true});
  test::KeptBones b(Bones(std::move(all), test::inline_workers()));
  Osteotomy o;
  o.kind = Osteotomy::Kind::plane, o.point_mm = {0, 0, kCut_mm}, o.normal = {0, 0, 1};
  EXPECT_TRUE(b.cut(o).done);
  EXPECT_TRUE(b.move(1, test::moved(Vec3::Zero(), deg * M_PI / 180, Vec3::UnitZ())).done);
  return b;
}

struct Seam {
  double rms_deg = 0;      // between the faces and the ball
  double farthest_mm = 0;  // from the ball
};

/// Over the faces no further than so many mm above or below the cut.
Seam seam_of(const Bones& b, double band_mm) {
  const simplex::FanTriangles fan = simplex::fan_triangles(b.mesh());
  Seam s;
  double sum = 0, area = 0;
  for (const Tri& t : fan.tri) {
    const Vec3 &p = fan.X_mm[size_t(t[0])], &q = fan.X_mm[size_t(t[1])], &r = fan.X_mm[size_t(t[2])];
    const Vec3 c = (p + q + r) / 3, n = (q - p).cross(r - p);
    if (std::abs(c.z() - kCut_mm) > band_mm || n.norm() < 1e-9) continue;
    const double deg = std::atan2(n.cross(c).norm(), n.dot(c)) * 180 / M_PI;
    sum += n.norm() * deg * deg, area += n.norm();
    s.farthest_mm = std::max(s.farthest_mm, std::abs(c.norm() - kRadius_mm));
  }
  s.rms_deg = std::sqrt(sum / area);
  return s;
}

// Measured 2026-11-27 at 7 and 20 degrees, within 2 mm of the cut: 11.7 -> 0.25 and 26.2 -> 0.26 degrees; the farthest
// place 0.048 -> 0.031 and 0.096 -> 0.041 mm from the ball (0.014 mm before the cut, by the size of the faces); volume
// to 1e-9.
TEST(Seam, SmoothingTakesTheSawToothOutAndKeepsTheVolume) {
  for (const double deg : {7.0, 20.0}) {
    test::KeptBones rough = turned_cap(deg), smooth = turned_cap(deg);
    ASSERT_TRUE(rough.join(0, 1).done);
    const Outcome o = smooth.join(0, 1, 8);
    ASSERT_TRUE(o.done) << o.reason;
    EXPECT_NE(o.reason.find("the seam is smoothed"), std::string::npos) << o.reason;
    const Seam before = seam_of(rough, 2), after = seam_of(smooth, 2);
    std::printf("%.0f deg: %.2f -> %.2f deg, %.3f -> %.3f mm\n", deg, before.rms_deg, after.rms_deg, before.farthest_mm,
                after.farthest_mm);
    EXPECT_LT(after.rms_deg, before.rms_deg / 20);
    EXPECT_LT(after.rms_deg, 0.5);
    EXPECT_LT(after.farthest_mm, 0.75 * before.farthest_mm);
    const double volume = rough.fragments()[0].volume_mm3;
    EXPECT_NEAR(smooth.fragments()[0].volume_mm3, volume, 1e-8 * volume);
    EXPECT_EQ(simplex::find_fault(smooth.mesh()).value_or(""), "");
  }
}

TEST(Seam, FarFromItNothingMovesAndItCanBeTakenBackAndDoneAgain) {
  test::KeptBones rough = turned_cap(7), b = turned_cap(7);
  ASSERT_TRUE(rough.join(0, 1).done);
  const uint64_t apart = b.hash();
  ASSERT_TRUE(b.join(0, 1, 8).done);
  int still = 0;
  for (int32_t v = 0; v < b.mesh().slots(); ++v) {
    const Vec3& x = rough.mesh().x_mm[size_t(v)];
    if (!b.mesh().alive(v) || std::abs(x.z() - kCut_mm) < 15) continue;
    ++still;
    EXPECT_EQ(b.mesh().x_mm[size_t(v)], x);
  }
  EXPECT_GT(still, 2000);
  const uint64_t joined = b.hash();
  EXPECT_NE(joined, rough.hash());
  ASSERT_TRUE(b.undo().done);
  EXPECT_EQ(b.hash(), apart);
  ASSERT_TRUE(b.redo().done);
  EXPECT_EQ(b.hash(), joined);
}

// The walls of another cut are what the saw left: they, and their rims, stay.
TEST(Seam, TheWallsOfOtherCutsHoldStill) {
  const auto sliced = [] {
    test::KeptBones b = turned_cap(7);
    Osteotomy other;
    other.kind = Osteotomy::Kind::plane, other.point_mm = {0, 0, kCut_mm - 4}, other.normal = {0.05, 0, 1};
    other.fragment = 0;
    EXPECT_TRUE(b.cut(other).done);
    return b;
  };
  test::KeptBones rough = sliced(), b = sliced();
  ASSERT_EQ(b.fragments().size(), 3u);
  ASSERT_TRUE(rough.join(1, 2).done);
  const Outcome o = b.join(1, 2, 12);  // the cap to the slice, 2 to 6 mm thick
  ASSERT_TRUE(o.done) << o.reason;
  int walls = 0, moved = 0;
  for (int32_t v = 0; v < b.mesh().slots(); ++v) {
    if (!b.mesh().alive(v)) continue;
    bool wall = false;
    for (const int32_t f : b.mesh().left[size_t(v)]) wall |= b.mesh().kind(f) == simplex::FaceKind::wall;
    const bool still = b.mesh().x_mm[size_t(v)] == rough.mesh().x_mm[size_t(v)];
    walls += wall, moved += !still;
    if (wall) {
      EXPECT_TRUE(still);
    }
  }
  EXPECT_GT(walls, 100);
  EXPECT_GT(moved, 300);
}

}  // namespace test_seam
}  // namespace limberg::bone
