// The box tree, groups of boxes, sorting by digits and by signs, and the four signs that tell how two triangles cross.
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/cutting/arrangement/radix_sort.h"
#include "sim/cutting/arrangement/sign_sort.h"
#include "sim/cutting/arrangement/tri_tests.h"

namespace limberg {
namespace test_boxes {

struct Draw {
  uint64_t state = 0x9e3779b97f4a7c15ull;
  int32_t operator()(int32_t n) {
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return int32_t((state >> 20) % uint64_t(n));
  }
  Int3 point(int32_t from, int32_t n) { return {from + (*this)(n), from + (*this)(n), from + (*this)(n)}; }
};

std::vector<std::array<Int3, 3>> cloud(Draw& draw, size_t n, int32_t size, int32_t unit) {
  std::vector<std::array<Int3, 3>> t(n);
  for (auto& c : t) {
    const Int3 o = draw.point(-1000 * unit, 2000 * unit);
    for (Int3& p : c) p = {o.x + draw(size * unit), o.y + draw(size * unit), o.z + draw(size * unit)};
  }
  return t;
}

IntBox grown(const IntBox& b, int32_t by) {
  return {{b.lo.x - by, b.lo.y - by, b.lo.z - by}, {b.hi.x + by, b.hi.y + by, b.hi.z + by}};
}
bool holds(const IntBox& outer, const IntBox& inner) {
  for (int k = 0; k < 3; ++k)
    if (inner.lo[k] < outer.lo[k] || inner.hi[k] > outer.hi[k]) return false;
  return true;
}

// Nothing that meets a box is missed. Boxes are rounded
// outwards by less than a step: not at all where the tree
// spans fewer than 2^16 half-units.
TEST(BoxTree, FindsWhatAskingEveryTriangleFinds) {
  Draw draw;
  size_t beyond = 0, met = 0;
  for (size_t n : {1u, 2u, 4u, 5u, 9u, 33u, 700u})
    for (int32_t size : {1, 60, 900})
      for (int32_t unit : {1, 700}) {
        const auto t = cloud(draw, n, size, unit);
        const BoxTree tree(t);
        IntBox around = box_around(t[0][0], t[0][1], t[0][2]);
        for (const auto& c : t) around = box_around(around, box_around(c[0], c[1], c[2]));
        ASSERT_TRUE(tree.all().lo == around.lo && tree.all().hi == around.hi);
        ASSERT_LE((around.hi.x - around.lo.x) / tree.step(), 1 << 16);
        if (unit == 1) {
          ASSERT_EQ(tree.step(), 1);
        }
        for (int q = 0; q < 80; ++q) {
          const Int3 lo = draw.point(-1100 * unit, 2200 * unit);
          const IntBox box{lo, {lo.x + draw(300 * unit), lo.y + draw(300 * unit), lo.z + draw(300 * unit)}};
          std::vector<uint8_t> seen(n, 0);
          std::vector<int32_t> found, by_fractions;
          tree.box(box, [&](int32_t i, const IntBox& b) {
            found.push_back(i);
            ASSERT_EQ(seen[size_t(i)]++, 0);
            const IntBox own = box_around(t[size_t(i)][0], t[size_t(i)][1], t[size_t(i)][2]);
            ASSERT_TRUE(holds(b, own) && holds(grown(own, tree.step() - 1), b));
            ASSERT_TRUE(b.meets(box));
            beyond += !own.meets(box);
          });
          for (size_t i = 0; i < n; ++i)
            if (box_around(t[i][0], t[i][1], t[i][2]).meets(box)) {
              ++met;
              ASSERT_TRUE(seen[i]);
            }
          tree.box(box_within(Vec3(box.lo.x - 0.75, box.lo.y - 0.25, box.lo.z - 0.5),
                              Vec3(box.hi.x + 0.75, box.hi.y + 0.25, box.hi.z + 0.5)),
                   [&](int32_t i) { by_fractions.push_back(i); });
          ASSERT_EQ(found, by_fractions);  // the same order too
        }
      }
  EXPECT_GT(met, 1000u);
  EXPECT_LT(beyond, met / 100);
  BoxTree().box(IntBox{}, [](int32_t) { FAIL(); });
}

// The query of a strip that lies at a slant leaves nothing out that touches one of its triangles, and leaves out most
// of what meets only the box around them.
TEST(SlantBox, LeavesOutOnlyWhatNoTriangleTouches) {
  Draw draw;
  size_t in_boxes = 0, in_slants = 0, touching = 0;
  for (int32_t far : {0, (1 << 20), (1 << 21) - 1300})  // where `float` is finest, and where it is coarsest
    for (int turn = 0; turn < 60; ++turn) {
      const auto place = [&](int32_t x, int32_t y, int32_t z) { return Int3{far + x, far + y, z - far}; };
      std::vector<std::array<Int3, 3>> cells;
      for (int i = 0; i < 400; ++i) {
        const int32_t x = draw(1000), y = draw(1000), z = draw(200);
        cells.push_back({place(x, y, z), place(x + 40, y + draw(20), z), place(x + draw(20), y + 40, z + draw(20))});
      }
      const BoxTree tree(cells);
      std::vector<IntTriangle> strip;
      std::vector<Plane> plane;
      const int32_t dx = 50 + draw(80), dy = draw(130);
      IntBox all;
      for (int32_t i = 0; i < 8; ++i) {
        IntTriangle t;
        t.p = {place(i * dx, i * dy, 220), place((i + 1) * dx, (i + 1) * dy + draw(3), i % 2 ? 220 : -20),
               place(i * dx, i * dy, -20)};
        t.id = {-3 * i - 1, -3 * i - 2, -3 * i - 3};
        const IntBox own = box_around(t.p[0], t.p[1], t.p[2]);
        all = i == 0 ? own : box_around(all, own);
        strip.push_back(t);
        plane.push_back(plane_through(t.p[0], t.p[1], t.p[2]));
      }
      std::vector<uint8_t> seen(cells.size(), 0);
      tree.box(slant_box(all, strip, plane), [&](int32_t i) { seen[size_t(i)] = 1, ++in_slants; });
      tree.box(all, [&](int32_t) { ++in_boxes; });
      for (size_t i = 0; i < cells.size(); ++i) {
        IntTriangle t;
        t.p = cells[i], t.id = {1, 2, 3};
        for (const IntTriangle& s : strip)
          if (meet_beyond_shared(s, t)) {
            ++touching;
            ASSERT_TRUE(seen[i]) << "triangle " << i << " at " << far;
          }
      }
    }
  EXPECT_GT(touching, 1000u);
  EXPECT_LT(3 * in_slants, 2 * in_boxes);  // strips along an axis are among them
}

TEST(BoxGroup, HoldsEveryBoxOnceAndTellsWhichMeet) {
  Draw draw;
  std::vector<IntBox> box;
  for (int i = 0; i < 200; ++i) {  // a strip with jumps
    const Int3 o{i * 40 + (i % 31 == 0 ? 5000 : 0), draw(50), -draw(50)};
    box.push_back(box_around(o, {o.x + 60, o.y + draw(40), o.z}, {o.x, o.y, o.z - 200}));
  }
  size_t next = 0, groups = 0;
  for (; next < box.size(); ++groups) {
    const BoxGroup g(box, next);
    ASSERT_EQ(g.first, next);
    ASSERT_GE(g.count, 1u);
    ASSERT_LE(g.count, BoxGroup::kMost);
    next = g.end();
    for (size_t j = 0; j < box.size(); ++j) {
      uint32_t expected = 0;
      for (size_t i = 0; i < g.count; ++i) expected |= uint32_t(box[g.first + i].meets(box[j])) << i;
      ASSERT_EQ(g.meeting(box[j]), expected);
      if (expected) {
        ASSERT_TRUE(g.all.meets(box[j]));
      }
    }
  }
  EXPECT_EQ(next, box.size());
  EXPECT_LT(groups, box.size() / 4);  // neighbours do go together
}

TEST(RadixSort, SortsAndKeepsTheOrderOfEquals) {
  Draw draw;
  struct Item {
    uint32_t key, place;
  };
  for (size_t n : {0u, 1u, 5u, 23u, 24u, 1000u})
    for (int bits : {1, 8, 13, 20}) {
      std::vector<Item> v, room;
      for (size_t i = 0; i < n; ++i) v.push_back({uint32_t(draw(1 << bits)), uint32_t(i)});
      auto expected = v;
      std::stable_sort(expected.begin(), expected.end(), [](const Item& a, const Item& b) { return a.key < b.key; });
      radix_sort(v, room, bits, [](const Item& x) { return uint64_t(x.key); });
      for (size_t i = 0; i < n; ++i) ASSERT_EQ(v[i].place, expected[i].place);
    }
  EXPECT_EQ(bits_of(0), 0);
  EXPECT_EQ(bits_of(255), 8);
  EXPECT_EQ(bits_of(256), 9);
}

TEST(Crossing, FourSignsTellWhatTwelveTell) {
  Draw draw;
  int crossing = 0, apart = 0, coincidence = 0;
  for (int i = 0; i < 200000; ++i) {
    const int32_t size = i % 4 == 0 ? 6 : 4000;  // small numbers: exact zeros are common
    IntTriangle s, t;
    for (size_t k = 0; k < 3; ++k)
      s.p[k] = draw.point(0, size), t.p[k] = draw.point(0, size), s.id[k] = int32_t(k), t.id[k] = 3 + int32_t(k);
    const Plane ps = plane_through(s.p[0], s.p[1], s.p[2]), pt = plane_through(t.p[0], t.p[1], t.p[2]);
    const Crossing a = cross_triangles(s, ps, t, pt), b = cross_triangles_exactly(s, ps, t, pt);
    ++(a.kind == Crossing::crossing ? crossing : a.kind == Crossing::apart ? apart : coincidence);
    if (a.kind == Crossing::coincidence) {
      // The exact test may find that a vertex in the other's plane does no harm. Without such a vertex both must agree.
      bool in_plane = false;
      for (size_t k = 0; k < 3; ++k)
        in_plane = in_plane || side_of_plane(pt, s.p[k]) == 0 || side_of_plane(ps, t.p[k]) == 0;
      if (!in_plane) {
        ASSERT_EQ(int(b.kind), int(Crossing::coincidence));
      }
      continue;
    }
    ASSERT_EQ(int(a.kind), int(b.kind));
    for (size_t e = 0; e < 2 && a.kind == Crossing::crossing; ++e) {
      ASSERT_EQ(a.end[e].edge_of_s, b.end[e].edge_of_s);
      ASSERT_EQ(a.end[e].edge, b.end[e].edge);
    }
  }
  EXPECT_GT(crossing, 10000);
  EXPECT_GT(apart, 10000);
  EXPECT_GT(coincidence, 10000);
}

// One comparison that fails, whichever it is, leaves what lies before
// and behind the range as it was, and in it the same elements.
TEST(SortBySigns, StaysWithinBoundsWhateverTheSignsSay) {
  Draw draw;
  for (size_t n : {0u, 1u, 2u, 3u, 7u, 40u})
    for (int round = 0; round < 20; ++round) {
      std::vector<int32_t> all(n + 8);
      for (int32_t& v : all) v = draw(1000);
      const auto sorted_with = [&](int strike) {  // the comparison that is to fail
        std::vector<int32_t> v = all;
        sort_by_signs(v.begin() + 4, v.end() - 4, [&](int32_t a, int32_t b) { return strike-- != 0 && a < b; });
        return v;
      };
      std::vector<int32_t> right = all;
      std::stable_sort(right.begin() + 4, right.end() - 4);
      ASSERT_EQ(sorted_with(-1), right);
      for (int strike = 0; strike < 60; ++strike) {
        std::vector<int32_t> v = sorted_with(strike);
        std::sort(v.begin() + 4, v.end() - 4);
        ASSERT_EQ(v, right) << strike;
      }
    }
}

}  // namespace test_boxes
}  // namespace limberg
