// The scenes of which the outcome is known by hand: pieces and V - E + F.
#include <gtest/gtest.h>

#include "sim/cutting/store.h"
#include "tests/sim/cutting/scenes.h"

namespace limberg::test {
namespace {

using Chi = std::vector<int>;

struct Slab : ::testing::Test {
  Arrangement a{wavy_slab(60, 12, 24, 0.8), grid()};
  uint64_t seed = 1;
  uint64_t initial = a.hash(), initial_full = a.full_hash();

  CutResult cut(const Blade& blade) {
    const CutResult r = a.cut(blade, seed++);
    EXPECT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(a.check_all(), "");
    return r;
  }
  void expect(int pieces, const Chi& chi) {
    EXPECT_EQ(a.pieces(), pieces);
    EXPECT_EQ(euler(a), chi);
  }
  ~Slab() override {
    while (a.undo()) EXPECT_EQ(a.check_all(), "");
    EXPECT_EQ(a.hash(), initial);
    EXPECT_EQ(a.full_hash(), initial_full);
  }
};

const std::vector<Vec2> kRhombus{{10, 0}, {0, 6}, {-10, 0}, {0, -6}};

TEST_F(Slab, UncutIsOneBall) { expect(1, {2}); }

TEST_F(Slab, PartialIncision) {
  cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6));
  expect(1, {2});
  EXPECT_GT(a.last_operation().new_walls.size(), 20u);
}

TEST_F(Slab, CrossOfPartialIncisions) {
  cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6));
  cut(strip({{1, -20}, {2, 20}}, 3, -4));
  expect(1, {2});
  cut(strip({{-15, -14}, {16, 15}}, 3, -8));
  expect(1, {2});
}

TEST_F(Slab, CrossThrough) {
  cut(strip({{-40, 0.3}, {40, 1.1}}, 3, -20));
  expect(2, {2, 2});
  cut(strip({{1, -40}, {2, 40}}, 3, -20));
  expect(4, {2, 2, 2, 2});
}

TEST_F(Slab, TInShallowerAndDeeper) {
  cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6));
  cut(strip({{1, -15}, {2, 0.9}}, 3, -4));
  expect(1, {2});
  cut(strip({{-8, 15}, {-7, 0.4}}, 3, -8));
  expect(1, {2});
}

TEST_F(Slab, TThroughMakesThreePieces) {
  cut(strip({{-40, 0.3}, {40, 1.1}}, 3, -20));
  cut(strip({{1, -40}, {2, 0.9}}, 3, -20));
  expect(3, {2, 2, 2});
}

TEST_F(Slab, WallsThenFloor) {
  cut(strip(kRhombus, 3, -6, true));
  expect(1, {2});
  cut(sheet({-12, -8, -4}, {24, 0, 0}, {0, 16, 0}, 12, 8));
  expect(2, {2, 2});
}

TEST_F(Slab, PlugComesOutWithItsExactVolume) {
  const double before = a.volume_mm3();
  const uint64_t residue = a.store().volume_residue;
  cut(open_box(kRhombus, 3, -6));
  expect(2, {2, 2});
  EXPECT_EQ(a.store().volume_residue, residue);
  const int32_t plug = a.loose_component_near({0, 0, 0}, 5);
  ASSERT_GE(plug, 0);
  const ExciseResult e = a.excise(plug);
  ASSERT_TRUE(e.done);
  EXPECT_EQ(a.check_all(), "");
  expect(1, {2});
  EXPECT_NEAR(a.volume_mm3() + e.volume_mm3, before, 1e-9 * before);
  EXPECT_NEAR(e.volume_mm3, 120 * 6, 120 * 0.8);  // the wavy skin
}

TEST_F(Slab, ThroughDrillLeavesATorus) {
  cut(strip(kRhombus, 3, -20, true));
  expect(2, {0, 2});
}

TEST_F(Slab, DrilledHole) {
  cut(strip({{8, 0.1}, {0.2, 5}, {-8, 0}, {0, -5}}, 3, -20, true));
  EXPECT_EQ(a.pieces(), 2);
  const int32_t plug = [&] {
    const auto& all = a.components();
    return all[0].volume_mm3 < all[1].volume_mm3 ? 0 : 1;
  }();
  ASSERT_TRUE(a.excise(plug).done);
  EXPECT_EQ(a.check_all(), "");
  expect(1, {0});
  cut(strip({{20, 1.3}, {5, 0.4}}, 3, -5));  // a slit into the hole
  expect(1, {0});
}

TEST_F(Slab, RhomboidFlap) {
  const double before = a.volume_mm3();
  cut(open_box(kRhombus, 3, -6));
  const ExciseResult e = a.excise(a.loose_component_near({0, 0, 0}, 5));
  ASSERT_TRUE(e.done);
  // From the obtuse corner D = (0, 6) outwards to E, then parallel to a side to F. D is pushed through the corner.
  const std::vector<Vec2> flap{{0, 5.9}, {0, 17}, {10, 11}};
  Blade b = strip(flap, 3, -6.2);
  b.seed[0] = b.seed[1] = 0;
  cut(b);
  expect(1, {2});
  const CutResult u = cut(sheet({-0.5, 2, -5.5}, {12, 0, 0}, {0, 16, 0}, 8, 10));
  expect(1, {2});
  EXPECT_GT(u.wall_faces, 50);
  EXPECT_NEAR(a.volume_mm3() + e.volume_mm3, before, 1e-9 * before);
}

}  // namespace
}  // namespace limberg::test
