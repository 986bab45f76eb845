// The index of the current surface: finding a rest point again, and choosing the bank of a wound.
#include <gtest/gtest.h>

#include "sim/geometry/polyline.h"
#include "sim/patient/anchors.h"
#include "sim/patient/rest_index.h"
#include "tests/sim/cutting/scenes.h"

namespace limberg {
namespace test_rest_index {

// A square of skin, 2 x 1 mm, slit along x = 1: two skin triangles a side, two wall triangles a bank, down to z = -1.
// Vertices 0..5 belong to the left bank, 6..11 to the right one.
SurfaceView slit_square() {
  SurfaceView v;
  const auto add = [&](double x, double y, double z) { v.X_mm.push_back({x, y, z}); };
  add(0, 0, 0), add(1, 0, 0), add(1, 1, 0), add(0, 1, 0), add(1, 0, -1), add(1, 1, -1);
  add(1, 0, 0), add(2, 0, 0), add(2, 1, 0), add(1, 1, 0), add(1, 0, -1), add(1, 1, -1);
  v.tri = {{0, 1, 2}, {0, 2, 3}, {2, 1, 4}, {2, 4, 5}, {6, 7, 8}, {6, 8, 9}, {6, 9, 10}, {9, 11, 10}};
  v.kind = {FaceKind::skin, FaceKind::skin, FaceKind::wall, FaceKind::wall,
            FaceKind::skin, FaceKind::skin, FaceKind::wall, FaceKind::wall};
  v.origin = {0, 1, 1, 1, 2, 3, 1, 1};
  return v;
}

TEST(RestIndex, FindsTheTriangleThatHoldsAPoint) {
  const SurfaceView view = slit_square();
  const RestIndex index(view, 4);
  const auto p = index.locate({1.8, 0.3, 0}, 2, 1e-9);
  ASSERT_TRUE(p);
  EXPECT_EQ(p->triangle, 4);
  EXPECT_NEAR((index.rest_mm(*p) - Vec3(1.8, 0.3, 0)).norm(), 0, 1e-12);
  EXPECT_FALSE(index.locate({1.8, 0.3, 0}, 0, 1e-9)) << "another original triangle does not hold it";
  EXPECT_FALSE(index.locate({1.8, 0.3, 0}, 99, 1e-9));
}

TEST(RestIndex, RimIsBothBanksOfTheSlit) {
  const SurfaceView view = slit_square();
  const RestIndex index(view, 4);
  EXPECT_EQ(index.rim_edges(), 2u);
  EXPECT_NEAR(index.rim_length_mm(), 2.0, 1e-12);
}

TEST(RestIndex, SnapsToTheBankWhereThePointLies) {
  const SurfaceView view = slit_square();
  const RestIndex index(view, 4);
  const auto left = index.snap_to_rim(*index.locate({0.9, 0.4, 0}, 0, 0.1), 0.5);
  const auto right = index.snap_to_rim(*index.locate({1.1, 0.05, 0}, 2, 0.1), 0.5);
  ASSERT_TRUE(left && right);
  EXPECT_EQ(left->triangle, 0);
  EXPECT_EQ(right->triangle, 5);
  EXPECT_NEAR(index.rest_mm(*left).x(), 1, 1e-12);
  EXPECT_NEAR(index.rest_mm(*left).y(), 0.4, 1e-12);
  EXPECT_NEAR(index.rest_mm(*right).y(), 0.05, 1e-12);
  EXPECT_FALSE(index.snap_to_rim(*index.locate({0.2, 0.1, 0}, 0, 1e-9), 0.5)) << "out of reach";
}

TEST(RestIndex, AnAnchorKeepsItsBankWhenTrianglesAreDividedAgain) {
  const SurfaceView before = slit_square();
  const RestIndex index(before, 4);
  const Anchor anchor = make_anchor(before, index, *index.snap_to_rim(*index.locate({1.1, 0.05, 0}, 2, 0.1), 0.5));
  // Divide triangle 5 = (6, 8, 9) at the middle of its rim edge.
  SurfaceView after = before;
  after.X_mm.push_back({1, 0.5, 0});
  after.tri[5] = {6, 8, 12};
  after.tri.push_back({12, 8, 9});
  after.kind.push_back(FaceKind::skin);
  after.origin.push_back(3);
  const RestIndex again(after, 4);
  const auto carried = carry_anchor(anchor, after, again);
  ASSERT_TRUE(carried);
  EXPECT_EQ(carried->at.triangle, 5);
  EXPECT_NEAR((again.rest_mm(carried->at) - anchor.X_mm).norm(), 0, 1e-12);
}

TEST(RestIndex, AnAnchorIsLostWithItsTissue) {
  const SurfaceView before = slit_square();
  const RestIndex index(before, 4);
  const Anchor anchor = make_anchor(before, index, *index.locate({1.8, 0.3, 0}, 2, 0.1));
  SurfaceView after = before;
  after.tri.resize(4), after.kind.resize(4), after.origin.resize(4);
  const RestIndex again(after, 4);
  EXPECT_FALSE(carry_anchor(anchor, after, again));
}

// After every cut the index made from the last one holds what one made from nothing holds, in the same order.
TEST(RestIndex, FollowsCutsAtTheirOwnCost) {
  const TriMesh slab = test::wavy_slab(60, 12, 24, 0.8);
  Arrangement a(slab, test::grid());
  SurfaceView view = a.surface_view();
  auto index = std::make_unique<const RestIndex>(view, slab.tri.size());
  int followed = 0;
  uint64_t seed = 5;
  const auto uniform = [&] {
    return -25 + 50 * double((seed = seed * 6364136223846793005ull + 1442695040888963407ull) >> 11) * 0x1p-53;
  };
  for (int i = 0; i < 12; ++i) {
    const int32_t operations = a.operations();
    const Vec2 p(uniform(), uniform()), q(uniform(), uniform());
    if (!a.cut(test::strip({p, q}, 3, i % 4 == 3 ? -14 : -4), uint64_t(i)).ok()) continue;
    ViewChange change;
    view = a.surface_view(view, operations, change);
    auto next = std::make_unique<const RestIndex>(view, *index, change);
    ASSERT_TRUE(next->same_as(RestIndex(view, slab.tri.size()))) << "cut " << i;
    followed += !change.whole;
    index = std::move(next);
  }
  EXPECT_GT(followed, 8);
  EXPECT_GT(index->rim_length_mm(), 300);
}

TEST(Resample, EqualStepsAlongAPolylineEndsIncluded) {
  const std::vector<Vec2> path = {{0, 0}, {3, 0}, {3, 0}, {3, 1}};
  EXPECT_DOUBLE_EQ(path_length(path), 4);
  const auto p = resample(path, 5);
  ASSERT_EQ(p.size(), 5u);
  EXPECT_NEAR((p[0] - Vec2(0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((p[2] - Vec2(2, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((p[3] - Vec2(3, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((p[4] - Vec2(3, 1)).norm(), 0, 1e-12);
}

}  // namespace test_rest_index
}  // namespace limberg
