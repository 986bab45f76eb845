// Fronto-orbital cuts on the synthetic head: around the rims of the orbits the saw is tilted (sim/skull/bone/aim.h).
#include <gtest/gtest.h>

#include <array>

#include "sim/imaging/synthetic/synthetic_head.h"
#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/osteotomy.h"
#include "sim/skull/bone/rigid_world.h"
#include "sim/skull/bone/surface.h"
#include "sim/skull/simplex/dual.h"
#include "tests/sim/skull/bone/heads.h"
#include "tests/sim/skull/simplex/random.h"

namespace limberg::bone {
namespace test_bandeau {

HeadSpec spec() {
  HeadSpec s;
  s.forehead_flat = 0.7;
  return s;
}

const simplex::Mesh& cranium() {
  static const simplex::Mesh m = make_head(spec(), test::inline_workers()).cranium;
  return m;
}

/// On the analytic skull (Newton along the gradient; the steps are damped at rims).
Vec3 on_skull(const HeadShape& shape, Vec3 p) {
  for (int k = 0; k < 30; ++k) {
    Vec3 g;
    for (int a = 0; a < 3; ++a) {
      Vec3 h = Vec3::Zero();
      h[a] = 0.05;
      g[a] = (shape.skull(p + h) - shape.skull(p - h)) / 0.1;
    }
    p -= 0.7 * shape.skull(p) * g / std::max(g.squaredNorm(), 0.05);
  }
  return p;
}

/// Over the forehead, down the temple, over the lateral rim into
/// the orbit, along its roof, over the medial rim to the nasion.
const std::vector<Vec3> kRight = {{0, 84, 58},  {12, 84, 58}, {24, 83, 57}, {35, 79, 55}, {44, 72, 50}, {51, 64, 43},
                                  {55, 61, 36}, {57, 60, 29}, {58, 63, 22}, {56, 70, 19}, {52, 73, 19}, {47, 72, 20},
                                  {44, 72, 24}, {38, 74, 28}, {31, 76, 30}, {24, 77, 29}, {18, 79, 25}, {15, 85, 21},
                                  {10, 89, 19}, {5, 92, 18},  {0, 93, 18}};

std::vector<Vec3> bandeau_picks(const HeadShape& shape) {
  std::vector<Vec3> picks;
  for (const Vec3& p : kRight) picks.push_back(on_skull(shape, p));
  for (size_t i = kRight.size() - 1; i-- > 1;)
    picks.push_back(on_skull(shape, {-kRight[i].x(), kRight[i].y(), kRight[i].z()}));
  return picks;
}

void expect_good(const simplex::Mesh& m, const Cut& cut, const HeadShape& shape, double least_mm3, double most_mm3) {
  EXPECT_EQ(cut.curves, 2);
  EXPECT_EQ(simplex::find_fault(m).value_or(""), "");
  EXPECT_EQ(simplex::census(m).components, 2);
  EXPECT_EQ(simplex::census(m).end_contours, 0);
  std::vector<int32_t> of;
  const int32_t n = simplex::components(m, of);
  const std::vector<Bulk> bulk = bulks(m, of, n);
  ASSERT_EQ(bulk.size(), 2u);
  const double small = std::min(bulk[0].volume_mm3, bulk[1].volume_mm3);
  EXPECT_GT(small, least_mm3);
  EXPECT_LT(small, most_mm3);
  // The wall lies within the bone: a face's centre may lie half a face's sagitta outside.
  for (int32_t f : cut.wall_left)
    EXPECT_LT(shape.skull(simplex::face_centre(m, f)), 1.) << simplex::face_centre(m, f).transpose();
}

TEST(Bandeau, IsCutByAContourAroundBothOrbits) {
  const HeadShape shape(spec());
  const std::vector<Vec3> picks = bandeau_picks(shape);
  std::vector<Vec3> drawn;
  for (size_t i = 0; i < picks.size(); ++i) {
    const Vec3 &a = picks[i], &b = picks[(i + 1) % picks.size()];
    const int n = int(std::ceil((b - a).norm() / 2));
    for (int k = 0; k < n; ++k) drawn.push_back(on_skull(shape, a + (b - a) * k / n));
  }
  for (const std::vector<Vec3>* way : std::array<const std::vector<Vec3>*, 2>{&drawn, &picks}) {
    const std::vector<Vec3>& path = *way;
    test::KeptBones bones({{"cranium", cranium(), true}}, test::inline_workers());
    Osteotomy o;
    o.path_mm = path;
    const uint64_t before = bones.hash();
    const double whole = bones.fragments()[0].volume_mm3;
    const Outcome done = bones.cut(o);
    ASSERT_TRUE(done.done) << done.reason;
    ASSERT_EQ(bones.fragments().size(), 2u);
    // Forehead, roofs of both orbits behind the rim, rims, nasion:
    // all one piece. The vault and the cheek bones are the other.
    for (const Vec3& p : {Vec3(0, 86, 45), Vec3(31, 80, 30.5), Vec3(-31, 80, 30.5), Vec3(34, 84, 33), Vec3(-34, 84, 33),
                          Vec3(0, 92, 30), Vec3(54, 70, 27), Vec3(-54, 70, 27)})
      EXPECT_EQ(bones.nearest_fragment(on_skull(shape, p)), 1) << p.transpose();
    for (const Vec3& p : {Vec3(0, 80, 70), Vec3(53, 62, -6), Vec3(-53, 62, -6), Vec3(0, 98, 5), Vec3(20, 60, 13)})
      EXPECT_EQ(bones.nearest_fragment(p), 0) << p.transpose();
    const double sum = bones.fragments()[0].volume_mm3 + bones.fragments()[1].volume_mm3;
    EXPECT_NEAR(sum, whole, 2e-4 * whole);
    // It lies in its place without gap or overlap, and comes off forwards.
    std::vector<Gap> gaps = bones.gaps();
    ASSERT_EQ(gaps.size(), 1u);
    EXPECT_LT(gaps[0].gap_max_mm, 1e-6);
    EXPECT_LT(gaps[0].overlap_max_mm, 2 * RigidWorld::kInset_mm);  // what rests without touching
    ASSERT_TRUE(bones.move(1, test::moved({0, 8, 0})).done);
    if (way == &picks) {
      gaps = bones.gaps();
      ASSERT_EQ(gaps.size(), 1u);
      EXPECT_GT(gaps[0].gap_max_mm, 3);
      EXPECT_EQ(gaps[0].overlap_max_mm, 0);
    }
    ASSERT_TRUE(bones.undo().done && bones.undo().done);
    EXPECT_EQ(bones.hash(), before);
  }
}

TEST(Bandeau, IsCutWhereverThePicksLieALittleOff) {
  const HeadShape shape(spec());
  test::Random random(11);
  for (int k = 0; k < 10; ++k) {
    std::vector<Vec3> path;
    for (const Vec3& p : bandeau_picks(shape)) path.push_back(on_skull(shape, p + random.vec(0.8)));
    simplex::Mesh m = cranium();
    Osteotomy o;
    o.path_mm = path;
    simplex::Delta d;
    const Cut cut = cut_bone(m, 0, o, d);
    ASSERT_TRUE(cut) << k << ": " << cut.reason;
    expect_good(m, cut, shape, 30e3, 45e3);
  }
}

TEST(Bandeau, OneRimAlone) {
  // The supraorbital rim of the right side with the roof behind it: from the middle of the forehead to the lateral rim.
  const HeadShape shape(spec());
  std::vector<Vec3> picks;
  for (const Vec3& p :
       {Vec3(14, 86, 48), Vec3(24, 84, 47), Vec3(34, 80, 46), Vec3(43, 74, 43), Vec3(50, 68, 38), Vec3(54, 66, 31),
        Vec3(54, 68, 25), Vec3(50, 72, 24), Vec3(46, 74, 24), Vec3(40, 75, 28), Vec3(33, 76, 30), Vec3(26, 77, 29),
        Vec3(20, 80, 27), Vec3(16, 86, 26), Vec3(12, 90, 29), Vec3(11, 89, 36), Vec3(12, 87, 42)})
    picks.push_back(on_skull(shape, p));
  simplex::Mesh m = cranium();
  Osteotomy o;
  o.path_mm = picks;
  simplex::Delta d;
  const Cut cut = cut_bone(m, 0, o, d);
  ASSERT_TRUE(cut) << cut.reason;
  expect_good(m, cut, shape, 5e3, 20e3);
}

}  // namespace test_bandeau
}  // namespace limberg::bone
