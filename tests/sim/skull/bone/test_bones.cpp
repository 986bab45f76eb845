// Fragments: numbers, poses, plates, undo and redo to the bit.
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/skull/bone/bones.h"
#include "tests/sim/skull/bone/heads.h"
#include "tests/sim/skull/simplex/random.h"

namespace limberg::bone {
namespace test_bones {

using test::chin, test::moved, test::window;

TEST(Bones, FragmentsAreNumberedAndKeepTheirAttributes) {
  test::KeptBones b = test::simple_head();
  ASSERT_EQ(b.fragments().size(), 2u);
  EXPECT_EQ(b.fragments()[0].name, "cranium");
  EXPECT_EQ(b.fragments()[1].name, "mandible");
  EXPECT_FALSE(b.physics());
  const uint64_t v = b.version();
  const double whole = b.fragments()[0].volume_mm3;
  const Outcome o = b.cut(window());
  ASSERT_TRUE(o.done) << o.reason;
  ASSERT_EQ(b.fragments().size(), 3u);
  const Fragment& piece = b.fragments()[2];
  EXPECT_EQ(piece.id, 2);
  EXPECT_EQ(piece.name, "cranium piece 2");
  EXPECT_FALSE(piece.fixed);
  EXPECT_TRUE(b.fragments()[0].fixed);
  EXPECT_GT(b.version(), v);
  EXPECT_NEAR(b.fragments()[0].volume_mm3 + piece.volume_mm3, whole, 1e-3 * whole);
  EXPECT_EQ(b.fragment_of(piece.vertex), 2);
  EXPECT_EQ(b.nearest_fragment({0, 76, 38}), 2);
  EXPECT_FALSE(b.move(0, moved({1, 0, 0})).done);
  EXPECT_FALSE(b.move(9, moved({1, 0, 0})).done);
  ASSERT_TRUE(b.move(2, moved({0, 8, 0}, 0.1)).done);
  EXPECT_LT((b.now_mm(piece.vertex) - moved({0, 8, 0}, 0.1) * b.mesh().x_mm[size_t(piece.vertex)]).norm(), 1e-12);
  EXPECT_THROW(Bones({}, test::inline_workers()), InputError);
}

TEST(Bones, PlatesHoldTogether) {
  test::KeptBones b = test::simple_head();
  ASSERT_TRUE(b.cut(chin()).done);
  ASSERT_EQ(b.fragments().size(), 3u);
  ASSERT_TRUE(b.plate({8, 67, -90}, {16, 65, -90}).done);
  EXPECT_FALSE(b.plate({8, 67, -90}, {8, 66, -92}).done);
  const Eigen::Isometry3d p = moved({0, 5, 1}, 0.2);
  ASSERT_TRUE(b.move(1, p).done);
  for (int32_t id : {1, 2}) EXPECT_LT((b.fragment(id)->pose.matrix() - p.matrix()).norm(), 1e-12);
  const uint64_t plated = b.hash();
  EXPECT_FALSE(b.unplate(0).done);  // there is none on the cranium
  EXPECT_FALSE(b.unplate(9).done);
  EXPECT_EQ(b.hash(), plated);
  ASSERT_TRUE(b.unplate(2).done);
  ASSERT_TRUE(b.undo().done);
  EXPECT_EQ(b.hash(), plated);
  ASSERT_TRUE(b.redo().done);
  ASSERT_TRUE(b.move(1, Eigen::Isometry3d::Identity()).done);
  EXPECT_LT((b.fragment(2)->pose.matrix() - p.matrix()).norm(), 1e-12);
}

TEST(Bones, JoinIsTheInverseOfACut) {
  test::KeptBones b = test::simple_head();
  const double whole = b.fragments()[0].volume_mm3;
  const simplex::Census c = simplex::census(b.mesh());
  for (const Osteotomy& o : {window(), chin()}) {
    ASSERT_TRUE(b.cut(o).done);
    const uint64_t cut = b.hash();
    const int32_t piece = b.fragments().back().id;
    const Outcome j = b.join(o.kind == Osteotomy::Kind::plane ? 1 : 0, piece);
    ASSERT_TRUE(j.done) << j.reason;
    EXPECT_EQ(simplex::find_fault(b.mesh()).value_or(""), "");
    EXPECT_EQ(simplex::census(b.mesh()), c);
    EXPECT_NEAR(b.fragments()[0].volume_mm3, whole, 1e-9 * whole);
    ASSERT_TRUE(b.undo().done);
    EXPECT_EQ(b.hash(), cut);
    ASSERT_TRUE(b.undo().done);
  }
  // Moved apart: across the gap, and the fixed one stays.
  ASSERT_TRUE(b.cut(window()).done);
  ASSERT_TRUE(b.move(2, moved({0, 5, 2})).done);
  const Outcome j = b.join(2, 0);
  ASSERT_TRUE(j.done) << j.reason;
  EXPECT_EQ(simplex::find_fault(b.mesh()).value_or(""), "");
  EXPECT_EQ(simplex::census(b.mesh()).end_contours, 0);
  EXPECT_EQ(simplex::census(b.mesh()).genus, 0);
  EXPECT_TRUE(b.fragment(0)->fixed);
  EXPECT_EQ(b.fragment(2), nullptr);
  EXPECT_FALSE(b.join(0, 1).done);  // no cut surfaces
}

TEST(Bones, RandomActsReturnToEveryState) {
  test::KeptBones b = test::simple_head();
  test::Random random(3);
  std::vector<uint64_t> states{b.hash()};
  int cuts = 0, joins = 0, refused = 0;
  for (int i = 0; i < 150; ++i) {
    const int what = random.below(10);
    const uint64_t now = b.hash();
    Outcome o;
    if (what < 3) {
      Osteotomy cut;
      cut.kind = Osteotomy::Kind::plane, cut.point_mm = random.vec(60), cut.normal = random.vec();
      if (random.below(2)) cut.radius_mm = 40;
      if (random.below(3) == 0)
        cut.kind = Osteotomy::Kind::contour,
        cut.path_mm = test::on_ellipsoid(test::circle(Vec3(0, 70, 20) + random.vec(20),
                                                      {random.uniform(-.5, .5), 1, random.uniform(0, 1)},
                                                      random.uniform(10, 30), 60));
      o = b.cut(cut);
      cuts += o.done;
    } else if (what < 5 && b.fragments().size() > 2) {
      const int n = int(b.fragments().size());
      o = b.join(b.fragments()[size_t(random.below(n))].id, b.fragments()[size_t(random.below(n))].id);
      joins += o.done;
    } else if (what < 7) {
      o = b.move(b.fragments()[size_t(random.below(int(b.fragments().size())))].id,
                 moved(random.vec(3), random.uniform(-.05, .05), random.vec() + Vec3(2, 0, 0)));
    } else if (what == 7) {
      o = i % 2 ? b.plate(random.vec(70), random.vec(70))
                : b.unplate(b.fragments()[size_t(random.below(int(b.fragments().size())))].id);
    } else {
      // Back by some and on again by fewer.
      const int back = random.below(4), again = back > 0 ? random.below(back) : 0;
      int k = 0;
      for (; k < back && b.can_undo(); ++k) {
        ASSERT_TRUE(b.undo().done);
        states.pop_back();
        ASSERT_EQ(b.hash(), states.back());
      }
      std::vector<uint64_t> there;
      for (int r = 0; r < std::min(again, k); ++r) {
        ASSERT_TRUE(b.redo().done);
        states.push_back(b.hash());
        there.push_back(b.hash());
      }
      for (size_t r = there.size(); r-- > 0;) {
        ASSERT_TRUE(b.undo().done);
        states.pop_back();
        ASSERT_EQ(b.hash(), states.back());
      }
      for (uint64_t h : there) {
        ASSERT_TRUE(b.redo().done);
        ASSERT_EQ(b.hash(), h);
        states.push_back(h);
      }
      continue;
    }
    ASSERT_EQ(simplex::find_fault(b.mesh()).value_or(""), "") << i;
    EXPECT_EQ(simplex::census(b.mesh()).end_contours, 0);
    EXPECT_EQ(simplex::census(b.mesh()).components, int64_t(b.fragments().size()));
    for (const Fragment& f : b.fragments()) {
      EXPECT_EQ(b.fragment_of(f.vertex), f.id);
      EXPECT_GT(f.volume_mm3, 0);
    }
    if (!o.done) {
      EXPECT_EQ(b.hash(), now) << o.reason;
    }
    o.done ? states.push_back(b.hash()) : void(++refused);
  }
  EXPECT_GT(cuts, 5);
  EXPECT_GT(joins, 0);
  while (b.can_undo()) {
    ASSERT_TRUE(b.undo().done);
    states.pop_back();
    ASSERT_EQ(b.hash(), states.back());
  }
  EXPECT_EQ(states.size(), 1u);
  while (b.can_redo()) ASSERT_TRUE(b.redo().done);
}

}  // namespace test_bones
}  // namespace limberg::bone
