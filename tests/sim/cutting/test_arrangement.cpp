// The scenes of which the outcome is known by hand: pieces and V - E + F.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "sim/cutting/arrangement/store.h"
#include "tests/sim/cutting/scenes.h"

namespace limberg::test {
namespace test_arrangement {

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

TEST_F(Slab, WhatOfABladeStandsAboveTheSkinIsNotDivided) {
  const auto without_material = [&](int32_t below) {  // of original triangles with smaller names
    return std::count_if(a.faces().begin(), a.faces().end(),
                         [&](const Face& f) { return !f.retired && f.mat == 0 && f.orig < below; });
  };
  cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6));
  const int32_t triangles = int32_t(a.store().orig.size());
  const auto before = without_material(triangles);
  EXPECT_GT(before, 40);  // the blade's upper half
  cut(strip({{1, -20}, {2, 20}}, 3, -4));
  EXPECT_EQ(without_material(triangles),
            before + 1);  // only where the two leave the skin together: a point on its border
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

// What is near is what asking every original triangle finds, each once, whatever was cut, taken back and cut again.
TEST_F(Slab, TrianglesNearABoxWhateverHasHappened) {
  const ArrangementStore& s = a.store();
  uint64_t state = 77;
  const auto random = [&](int32_t from, int32_t to) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return from + int32_t((state >> 33) % uint64_t(to - from));
  };
  size_t met = 0;
  const auto compare = [&] {
    for (int i = 0; i < 60; ++i) {
      const Int3 m = at(random(-32, 32), random(-32, 32), random(-14, 3));
      const int32_t r = random(1, 100000);
      const IntBox q{{m.x - r, m.y - r, m.z - r}, {m.x + r, m.y + r, m.z + r}};
      std::vector<int32_t> body, blades, found;  // what meets q is found, and perhaps what lies a step beside it
      const auto meets = [&](int32_t o, int32_t beside) {
        const auto& v = s.orig[size_t(o)].v;
        const IntBox b = box_around(s.points.integer(v[0]), s.points.integer(v[1]), s.points.integer(v[2]));
        return b.meets(
            {{q.lo.x - beside, q.lo.y - beside, q.lo.z - beside}, {q.hi.x + beside, q.hi.y + beside, q.hi.z + beside}});
      };
      for (int32_t o = 0; o < int32_t(s.orig.size()); ++o)
        if (meets(o, 0)) (s.is_body(o) ? body : blades).push_back(o);
      const auto note = [&](int32_t o, const IntBox& box) {
        found.push_back(o);
        EXPECT_TRUE(box.meets(q));
        EXPECT_TRUE(meets(o, s.op[size_t(s.orig[size_t(o)].op)].boxes.step() - 1));
      };
      const auto each_once = [&](const std::vector<int32_t>& expected) {
        std::sort(found.begin(), found.end());
        EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
        EXPECT_TRUE(std::includes(found.begin(), found.end(), expected.begin(), expected.end()));
        found.clear();
      };
      s.body_near(q, note);
      each_once(body);
      s.blades_near(q, note);
      each_once(blades);
      met += blades.size();
    }
    EXPECT_LE(s.forest.size(), size_t(std::bit_width(s.op.size())));
  };
  compare();
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 9; ++i) {
      const Vec2 p(random(-25, 25) + 0.13, random(-25, 25) + 0.21), d(random(-12, 12) + 0.4, random(-12, 12) + 0.3);
      a.cut(strip({p, p + d}, 3, -random(3, 9)), seed++);
      compare();
    }
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(a.undo());
      compare();
    }
  }
  EXPECT_GT(met, 1000u);
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

}  // namespace test_arrangement
}  // namespace limberg::test
