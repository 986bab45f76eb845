// Bone under a face, and bone pushed through it.
#include <gtest/gtest.h>

#include "sim/measure/bone_outside.h"

namespace limberg {
namespace test_bone_outside {

constexpr int kSide = 21;  // places along a side, 2 mm apart

/// A face at z = 0 that looks up, and a plate of bone of a third of its side below its middle, `depth_mm` deep. What
/// reaches beyond the face's border lies at its height + 5.
Snapshot head(double depth_mm, bool beyond_border = false) {
  auto top = std::make_shared<SurfaceTopology>();
  const auto sheet = [&](double z, double from, int n, Organ organ) {
    const auto base = int32_t(top->view.X_mm.size());
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) top->view.X_mm.push_back(Vec3(from + 2 * i, from + 2 * j, z));
    for (int32_t j = 0; j + 1 < n; ++j)
      for (int32_t i = 0; i + 1 < n; ++i)
        for (const Tri& t : {Tri{0, 1, n + 1}, Tri{0, n + 1, n}}) {
          const int32_t at = base + j * n + i;
          top->view.tri.push_back({at + t[0], at + t[1], at + t[2]});
          top->view.kind.push_back(FaceKind::free);
          top->organ.push_back(organ);
          top->object.push_back(organ == Organ::bone ? 3 : -1);
        }
  };
  sheet(0, -20, kSide, Organ::face);
  sheet(-depth_mm, -6, 7, Organ::bone);
  if (beyond_border) sheet(5, 24, 4, Organ::bone);
  Snapshot s;
  for (const Vec3& X : top->view.X_mm) s.x_mm.push_back(X.cast<float>());
  s.topology = top;
  return s;
}

TEST(BoneOutside, UnderTheFaceIsNone) {
  EXPECT_EQ(bone_outside(head(4)).depth_mm, 0);
  EXPECT_EQ(bone_outside(Snapshot{}).depth_mm, 0);
}

TEST(BoneOutside, WhatIsPushedThroughIsSeenWithItsFragment) {
  Snapshot s = head(4);
  for (size_t i = kSide * kSide; i < s.x_mm.size(); ++i) s.x_mm[i].z() += 6;
  const BoneOutside b = bone_outside(s);
  EXPECT_NEAR(b.depth_mm, 2, 1e-5);
  EXPECT_NEAR(b.area_mm2, 144, 1e-3);
  EXPECT_EQ(b.object, 3);
  EXPECT_NEAR(b.at_mm.z(), 2, 1e-5);
}

TEST(BoneOutside, WhereTheFaceHasEndedOrBoneStoodOutBeforeIsNone) {
  EXPECT_EQ(bone_outside(head(4, true)).depth_mm, 0);
  EXPECT_EQ(bone_outside(head(-3)).depth_mm, 0);
}

}  // namespace test_bone_outside
}  // namespace limberg
