// Work on a bone's surface: finer, coarser, smoothed, pushed; taken back and made again to the bit.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/skull/bone/heads.h"

namespace limberg::bone {
namespace test_surface_work {

constexpr double kRadius_mm = 40;
using Kind = SurfaceWork::Kind;

test::KeptBones ball() {
  std::vector<NamedMesh> all;
  all.push_back({"ball", test::ellipsoid(4, Vec3::Constant(kRadius_mm)), true});
  all.push_back({"other", test::ellipsoid(3, Vec3::Constant(10)), false});
  for (Vec3& x : all.back().mesh.x_mm) x += Vec3(0, 0, -200);
  return test::KeptBones(Bones(std::move(all), test::inline_workers()));
}
const Vec3 kTop(0, 0, kRadius_mm);

/// Done, taken back, made again: each time the same bits, and a sound mesh.
std::string done_and_undone(test::KeptBones& b, const SurfaceWork& w) {
  const uint64_t before = b.full_hash();
  const Outcome o = b.work(0, w);
  EXPECT_TRUE(o.done) << o.reason;
  EXPECT_EQ(simplex::find_fault(b.mesh()).value_or(""), "");
  const uint64_t after = b.full_hash();
  EXPECT_NE(after, before);
  EXPECT_TRUE(b.undo().done);
  EXPECT_EQ(b.full_hash(), before);
  EXPECT_TRUE(b.redo().done);
  EXPECT_EQ(b.full_hash(), after);
  return o.reason;
}

void refused(test::KeptBones& b, int32_t id, const SurfaceWork& w, const std::string& why) {
  const uint64_t before = b.full_hash();
  const Outcome o = b.work(id, w);
  EXPECT_FALSE(o.done) << why;
  EXPECT_NE(o.reason.find(why), std::string::npos) << o.reason;
  EXPECT_EQ(b.full_hash(), before) << why;
}

TEST(SurfaceWork, AFaceIsSplitAndFacesAreMerged) {
  test::KeptBones b = ball();
  const simplex::Census first = simplex::census(b.mesh());
  done_and_undone(b, {Kind::split_face, kTop, kTop, 0});
  simplex::Census c = simplex::census(b.mesh());
  EXPECT_EQ(c.vertices - first.vertices, 2);  // as operators.h counts
  EXPECT_EQ(c.edges - first.edges, 3);
  EXPECT_EQ(c.faces - first.faces, 1);
  EXPECT_EQ(c.chi, first.chi);
  done_and_undone(b, {Kind::merge_faces, kTop, kTop, 0});
  c = simplex::census(b.mesh());
  EXPECT_EQ(c.vertices, first.vertices);
  EXPECT_EQ(c.faces, first.faces);
  // Until no face is left that may be merged: refused in words, sound throughout, and the fragment still known.
  Outcome o{true, ""};
  for (int i = 0; i < 2000 && o.done; ++i) o = b.work(0, {Kind::merge_faces, kTop, kTop, 0});
  EXPECT_FALSE(o.done);
  EXPECT_NE(o.reason.find("the faces cannot be merged: "), std::string::npos) << o.reason;
  EXPECT_EQ(simplex::find_fault(b.mesh()).value_or(""), "");
  EXPECT_EQ(b.nearest_fragment(kTop), 0);
  EXPECT_EQ(b.nearest_fragment({0, 0, -195}), 1);
}

TEST(SurfaceWork, ABallPushesTheSurfaceOutOfItsWay) {
  test::KeptBones b = ball();
  const double volume = b.fragment(0)->volume_mm3;
  const std::vector<Vec3> was = b.mesh().x_mm;
  const double R = 10;
  const Vec3 from(0, 0, kRadius_mm + R + 1), to(0, 0, kRadius_mm + 4);
  const std::string words = done_and_undone(b, {Kind::push, from, to, R});
  EXPECT_NE(words.find("places are pushed"), std::string::npos) << words;
  double nearest = 1e300;
  for (int32_t v = 0; v < b.mesh().slots(); ++v) {
    const Vec3& x = b.mesh().x_mm[size_t(v)];
    nearest = std::min(nearest, (x - to).norm());
    if ((was[size_t(v)] - to).norm() > 3 * R) {
      EXPECT_EQ(x, was[size_t(v)]) << v;  // what is far holds still
    }
  }
  EXPECT_GT(nearest, 0.95 * R);
  // What the ball takes up of the other: two caps of spheres 44 mm apart, of radii 10 and 40.
  const double d = kRadius_mm + 4, r = R, S = kRadius_mm;
  const double lens =
      M_PI * (S + r - d) * (S + r - d) * (d * d + 2 * d * r - 3 * r * r + 2 * d * S + 6 * r * S - 3 * S * S) / (12 * d);
  EXPECT_NEAR(volume - b.fragment(0)->volume_mm3, lens, 0.25 * lens);  // edges are 3 mm long there
}

TEST(SurfaceWork, SmoothingEvensADentAndKeepsTheVolume) {
  test::KeptBones b = ball();
  ASSERT_TRUE(b.work(0, {Kind::push, {0, 0, kRadius_mm + 11}, {0, 0, kRadius_mm + 4}, 10}).done);
  const auto depth = [&] {
    double low = kRadius_mm;
    for (int32_t v = 0; v < b.mesh().slots(); ++v)
      if (const Vec3& x = b.mesh().x_mm[size_t(v)]; x.z() > 0) low = std::min(low, x.norm());
    return kRadius_mm - low;
  };
  const double before = depth(), volume = b.fragment(0)->volume_mm3;
  ASSERT_GT(before, 4);
  done_and_undone(b, {Kind::smooth, {0, 0, kRadius_mm - 6}, {0, 0, 0}, 25});
  EXPECT_LT(depth(), 0.75 * before);
  EXPECT_NEAR(b.fragment(0)->volume_mm3, volume, 1e-6 * volume);
}

TEST(SurfaceWork, WhatCannotBeDoneIsRefusedInWords) {
  test::KeptBones b = ball();
  refused(b, 7, {Kind::smooth, kTop, kTop, 10}, "there is no fragment 7");
  refused(b, 0, {Kind::split_face, 3 * kTop, kTop, 0}, "there is no bone within 10 mm");
  refused(b, 0, {Kind::smooth, kTop, kTop, 0}, "the radius is not above 0");
  refused(b, 0, {Kind::push, 2 * kTop, 1.5 * kTop, 5}, "the ball meets no surface");
  refused(b, 0, {Kind::push, kTop, 1e6 * kTop, 5}, "expected at most");
  refused(b, 0, {Kind::smooth, {NAN, 0, 0}, kTop, 5}, "not finite");
  // On the wall of a cut.
  Osteotomy o;
  o.kind = Osteotomy::Kind::plane, o.point_mm = {0, 0, 20}, o.normal = {0, 0, 1}, o.fragment = 0;
  ASSERT_TRUE(b.cut(o).done);
  for (const Kind k : {Kind::split_face, Kind::merge_faces, Kind::smooth})
    refused(b, 0, {k, {0, 0, 20}, {0, 0, 20}, 3}, "the wall of a cut");
}

}  // namespace test_surface_work
}  // namespace limberg::bone
