// Fragments in the hand: contact without tunnelling, the same bits twice, plates, snap; gap and overlap.
#include <gtest/gtest.h>

#include "sim/skull/bone/bones.h"
#include "tests/sim/skull/bone/heads.h"
#include "tests/sim/skull/needs_bullet.h"

namespace limberg::bone {
namespace test_hold {

using test::moved, test::window;

constexpr double kFrame_s = 1. / 60;

/// The piece of the forehead, number 2.
test::KeptBones with_window() {
  test::KeptBones b = test::simple_head();
  EXPECT_TRUE(b.cut(window()).done);
  return b;
}
/// What the hand does at that speed, a frame at a time.
void drag_along(Bones& b, int32_t id, const Vec3& by_mm, double speed_mm_s) {
  const Eigen::Isometry3d from = b.fragment(id)->pose;
  const int n = int(std::ceil(by_mm.norm() / (speed_mm_s * kFrame_s)));
  for (int i = 1; i <= n; ++i) {
    b.drag(id, Eigen::Translation3d(by_mm * (double(i) / n)) * from);
    b.step(kFrame_s);
  }
}
Gap gap_of(const Bones& b, int32_t x, int32_t y) {
  for (const Gap& g : b.gaps())
    if (g.a == std::min(x, y) && g.b == std::max(x, y)) return g;
  return {};
}

TEST(Hold, AWorldExistsOnlyWhileSomethingIsHeld) {
  LIMBERG_NEEDS_BULLET();
  test::KeptBones b = with_window();
  EXPECT_FALSE(b.physics());
  b.step(kFrame_s);
  EXPECT_FALSE(b.grab(0).done);
  EXPECT_FALSE(b.grab(7).done);
  EXPECT_FALSE(b.release(2).done);
  const uint64_t before = b.hash();
  ASSERT_TRUE(b.grab(2).done);
  EXPECT_TRUE(b.physics());
  EXPECT_FALSE(b.grab(2).done);
  EXPECT_FALSE(b.cut(test::chin()).done);
  EXPECT_FALSE(b.undo().done);
  ASSERT_TRUE(b.release(2).done);
  EXPECT_FALSE(b.physics());
  EXPECT_EQ(b.hash(), before);
  ASSERT_TRUE(b.undo().done);  // the hold, which moved nothing and counts all the same
  EXPECT_EQ(b.fragments().size(), 3u);
  ASSERT_TRUE(b.undo().done);  // the cut
  EXPECT_EQ(b.fragments().size(), 2u);
}

TEST(Hold, FreeMotionIsExactAndAFragmentLeavesItsWindow) {
  LIMBERG_NEEDS_BULLET();
  test::KeptBones b = with_window();
  ASSERT_TRUE(b.grab(2).done);
  const Eigen::Isometry3d out = moved({0, 30, 12}, 0.2, {1, 0.2, 0});
  drag_along(b, 2, {0, 27, 13}, 200);
  EXPECT_LT((b.fragment(2)->pose.translation() - Vec3(0, 27, 13)).norm(), 1e-2);  // the walls did not hold it
  for (int i = 0; i < 4; ++i) b.drag(2, out), b.step(kFrame_s);
  EXPECT_EQ(b.fragment(2)->pose.matrix(), out.matrix());
  ASSERT_TRUE(b.release(2).done);
  EXPECT_EQ(b.fragment(2)->pose.matrix(), out.matrix());  // no gravity
  ASSERT_TRUE(b.undo().done);
  EXPECT_EQ(b.fragment(2)->pose.matrix(), Eigen::Isometry3d::Identity().matrix());
  ASSERT_TRUE(b.redo().done);
  EXPECT_EQ(b.fragment(2)->pose.matrix(), out.matrix());
}

// Two surfaces touch when they overlap by 2 kInset, and one
// substep of kStride may go by before contact answers: at
// most 0.25 + 0.25 + 0.4 mm. Measured 2026-11-21: see docs/validation.md.
constexpr double kDeepest_mm = 0.9;

TEST(Hold, NothingTunnelsAtOneMetrePerSecond) {
  LIMBERG_NEEDS_BULLET();
  for (const double speed : {1000., 100.}) {
    test::KeptBones b = with_window();
    ASSERT_TRUE(b.grab(2).done);
    drag_along(b, 2, {0, 27, 13}, 200);
    drag_along(b, 2, {40, 0, 0}, 200);
    // Flat onto the shell beside its window, then towards the middle of the head.
    const Vec3 in = -Vec3(40, 75, 45).normalized();
    drag_along(b, 2, 120 * in, speed);
    const Vec3 centre = b.fragment(2)->pose * b.fragment(2)->centre_mm;
    EXPECT_GT(centre.norm(), 60) << speed;  // still outside: the shell is 59 to 85 mm from the origin
    const Gap g = gap_of(b, 0, 2);
    EXPECT_LE(g.overlap_max_mm, kDeepest_mm) << speed;
    EXPECT_GT(b.physics_figures().contacts, 0);
    ASSERT_TRUE(b.release(2).done);
    std::printf("%.0f mm/s: overlap %.2f mm, %.1f mm^3\n", speed, g.overlap_max_mm, g.overlap_mm3);
  }
  // Out of the window edgeways: the walls hold it.
  test::KeptBones b = with_window();
  ASSERT_TRUE(b.grab(2).done);
  drag_along(b, 2, {8, 0, 0}, 1000);
  EXPECT_LE(gap_of(b, 0, 2).overlap_max_mm, kDeepest_mm);
  EXPECT_GT((b.fragment(2)->pose.translation() - Vec3(8, 0, 0)).norm(), 1);
  std::printf("edgeways: overlap %.2f mm\n", gap_of(b, 0, 2).overlap_max_mm);
}

TEST(Hold, OtherFragmentsArePushedAndTheSameDragsGiveTheSameBits) {
  LIMBERG_NEEDS_BULLET();
  uint64_t hash[2];
  for (uint64_t& h : hash) {
    test::KeptBones b = with_window();
    ASSERT_TRUE(b.cut(test::chin()).done);
    ASSERT_TRUE(b.grab(2).done);
    drag_along(b, 2, {0, 30, 15}, 400);
    drag_along(b, 2, {0, 0, -130}, 800);
    drag_along(b, 2, {0, -60, 0}, 800);  // against the mandible
    ASSERT_TRUE(b.release(2).done);
    EXPECT_NE(b.fragment(1)->pose.matrix(), Eigen::Isometry3d::Identity().matrix());
    for (const Gap& g : b.gaps()) EXPECT_LE(g.overlap_max_mm, kDeepest_mm) << g.a << " " << g.b;
    h = b.hash();
    ASSERT_TRUE(b.undo().done);
    ASSERT_TRUE(b.redo().done);
    EXPECT_EQ(b.hash(), h);
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(Hold, PlatedFragmentsAreOneBody) {
  LIMBERG_NEEDS_BULLET();
  test::KeptBones b = with_window();
  ASSERT_TRUE(b.cut(test::chin()).done);
  ASSERT_TRUE(b.plate({8, 67, -90}, {16, 65, -90}).done);
  ASSERT_TRUE(b.grab(3).done);
  drag_along(b, 3, {0, 10, -20}, 100);
  ASSERT_TRUE(b.release(3).done);
  EXPECT_LT((b.fragment(1)->pose.matrix() - b.fragment(3)->pose.matrix()).norm(), 1e-9);
  EXPECT_NEAR(b.fragment(1)->pose.translation().y(), 10, 1e-3);
  // Plated to what is fixed: it cannot be taken.
  ASSERT_TRUE(b.plate({0, 76, 38}, test::on_ellipsoid({{30, 60, 45}})[0]).done);
  EXPECT_NE(b.grab(2).reason.find("fixed"), std::string::npos);
}

TEST(Hold, SnapPutsItWhereItFits) {
  LIMBERG_NEEDS_BULLET();
  test::KeptBones b = with_window();
  ASSERT_TRUE(b.move(2, moved({0.5, 2, 1}, 0.02)).done);
  ASSERT_TRUE(b.grab(2).done);
  ASSERT_TRUE(b.release(2, true).done);
  EXPECT_EQ(b.fragment(2)->pose.matrix(), Eigen::Isometry3d::Identity().matrix());
  const Eigen::Isometry3d far = moved({0, 9, 1});
  ASSERT_TRUE(b.move(2, far).done);
  ASSERT_TRUE(b.grab(2).done);
  ASSERT_TRUE(b.release(2, true).done);
  EXPECT_EQ(b.fragment(2)->pose.matrix(), far.matrix());
}

TEST(Gaps, OfAPlaneCutAreTheMove) {
  // Solid bone cut by a plane and moved: apart along the normal, then together.
  std::vector<NamedMesh> all;
  all.push_back({"block", test::ellipsoid(4, {30, 20, 20}), false});
  test::KeptBones b(std::move(all), test::inline_workers());
  Osteotomy o;
  o.kind = Osteotomy::Kind::plane, o.point_mm = {5, 0, 0}, o.normal = {1, 0, 0};
  ASSERT_TRUE(b.cut(o).done);
  Gap g = gap_of(b, 0, 1);
  EXPECT_LT(g.gap_max_mm, 1e-2);  // crossings keep 1/1000 of an edge from its ends
  EXPECT_LT(g.overlap_max_mm, 1e-2);
  ASSERT_TRUE(b.move(1, moved({3, 0, 0})).done);
  g = gap_of(b, 0, 1);
  EXPECT_NEAR(g.gap_mean_mm, 3, 0.02);
  EXPECT_NEAR(g.gap_max_mm, 3, 0.02);
  EXPECT_EQ(g.overlap_mm3, 0);
  ASSERT_TRUE(b.move(1, moved({-2, 0, 0})).done);
  g = gap_of(b, 0, 1);
  // The section is an ellipse of half axes 20 sqrt(1 - (5 / 30)^2); the piece on the right lies 2 mm within the other.
  double area = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = 3 + 2 * (i + 0.5) / 1000, right = x + 2, r2 = std::min(1 - x * x / 900, 1 - right * right / 900);
    area += std::numbers::pi * 400 * r2 / 1000;
  }
  EXPECT_NEAR(g.overlap_max_mm, 2, 0.02);
  EXPECT_NEAR(g.overlap_mm3, 2 * area, 0.03 * 2 * area);
  EXPECT_NEAR(g.gap_max_mm, 0, 1e-9);
}

}  // namespace test_hold
}  // namespace limberg::bone
