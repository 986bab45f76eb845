// The generated block is what its header says: closed, oriented, on the even grid, exactly flat and of exact volume.
#include <gtest/gtest.h>

#include <map>

#include "sim/base/error.h"
#include "sim/body/block.h"

namespace limberg {
namespace test_block {

int euler_of_closed(const TriMesh& m) {
  std::map<std::pair<int32_t, int32_t>, int> directed;
  for (const Tri& t : m.tri)
    for (int k = 0; k < 3; ++k) ++directed[{t[size_t(k)], t[size_t((k + 1) % 3)]}];
  for (const auto& [e, n] : directed) {
    EXPECT_EQ(n, 1);
    EXPECT_TRUE(directed.contains({e.second, e.first}));
  }
  return int(m.X_mm.size()) - int(directed.size() / 2) + int(m.tri.size());
}

double volume(const TriMesh& m) {
  double v = 0;
  for (const Tri& t : m.tri) v += m.X_mm[size_t(t[0])].dot(m.X_mm[size_t(t[1])].cross(m.X_mm[size_t(t[2])])) / 6;
  return v;
}

TEST(Block, DefaultIsClosedFineAndOnTheGrid) {
  const Body b = make_block({});
  EXPECT_GE(b.surface.tri.size(), 50000u);
  EXPECT_LT(b.surface.tri.size(), 80000u);
  EXPECT_EQ(euler_of_closed(b.surface), 2);
  EXPECT_NEAR(volume(b.surface), 144000, 1e-6);  // 2e5 terms of 1e5 at 1e-16
  EXPECT_EQ(b.surface.tag.size(), b.surface.tri.size());
  EXPECT_EQ(b.surface.uv.size(), b.surface.tri.size());
  for (const Vec3& X : b.surface.X_mm) ASSERT_EQ(b.grid.to_mm(b.grid.to_grid(X)), X);
  double skin_area = 0;
  for (size_t t = 0; t < b.surface.tri.size(); ++t) {
    const auto& c = b.surface.tri[t];
    const Vec3 n = (b.surface.X_mm[size_t(c[1])] - b.surface.X_mm[size_t(c[0])])
                       .cross(b.surface.X_mm[size_t(c[2])] - b.surface.X_mm[size_t(c[0])]);
    ASSERT_GT(n.norm(), 0);
    const bool top = b.surface.X_mm[size_t(c[0])].z() == 0 && b.surface.X_mm[size_t(c[1])].z() == 0 &&
                     b.surface.X_mm[size_t(c[2])].z() == 0;
    ASSERT_EQ(top, b.surface.tag[t] == SurfaceTag::skin);
    if (top) {
      ASSERT_GT(n.z(), 0);
      skin_area += 0.5 * n.z();
    }
    for (const auto& uv : b.surface.uv[t]) ASSERT_TRUE(uv.allFinite());
  }
  EXPECT_NEAR(skin_area, 14400, 1e-6);
}

TEST(Block, OddSizesCloseToo) {
  for (const Vec3& size : {Vec3(33.3, 20.1, 0.7), Vec3(7, 300, 40), Vec3(1, 1, 1), Vec3(500, 10, 3)}) {
    BlockSpec s;
    s.size_mm = size;
    s.skin_cell_mm = 1.7;
    const Body b = make_block(s);
    EXPECT_EQ(euler_of_closed(b.surface), 2);
    const Vec3 d = b.box_max_mm - b.box_min_mm;
    EXPECT_NEAR(volume(b.surface), d.prod(), 1e-9 * d.prod());
    EXPECT_LE((d - size).cwiseAbs().maxCoeff(), b.grid.unit_mm);
  }
}

TEST(Block, RefusesNonsense) {
  for (const Vec3& size :
       {Vec3(-1, 10, 10), Vec3(0, 10, 10), Vec3(NAN, 10, 10), Vec3(10, INFINITY, 10), Vec3(5000, 10, 10)}) {
    BlockSpec s;
    s.size_mm = size;
    EXPECT_THROW(make_block(s), InputError);
  }
  BlockSpec s;
  s.skin_cell_mm = 1e-4;
  EXPECT_THROW(make_block(s), InputError);
}

}  // namespace test_block
}  // namespace limberg
