// Overlaps of known depth, and the two ways to a winding number.
#include <gtest/gtest.h>

#include <cmath>

#include "../fem/models.h"
#include "sim/measure/penetration.h"

namespace limberg {
namespace test_penetration {

/// Adds a box of walls, n x n squares a side.
void add_box(SurfaceView& v, const Vec3& lo, const Vec3& hi, int n, FaceKind kind = FaceKind::wall) {
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      const int32_t base = int32_t(v.X_mm.size());
      const int u = (axis + 1) % 3, w = (axis + 2) % 3;
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
          Vec3 p;
          p[axis] = side ? hi[axis] : lo[axis];
          p[u] = lo[u] + (hi[u] - lo[u]) * i / n, p[w] = lo[w] + (hi[w] - lo[w]) * j / n;
          v.X_mm.push_back(p);
        }
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const int32_t a = base + j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
          for (Tri t : {Tri{a, b, d}, Tri{a, d, c}}) {
            if (side == 0) std::swap(t[1], t[2]);
            v.tri.push_back(t);
            v.kind.push_back(kind);
          }
        }
    }
}

std::vector<Vec3f> at_rest(const SurfaceView& v) {
  std::vector<Vec3f> x;
  for (const Vec3& X : v.X_mm) x.push_back(X.cast<float>());
  return x;
}

TEST(Penetration, TwoBoxesThatOverlapByHalfAMillimetre) {
  SurfaceView v;
  add_box(v, {0, 0, 0}, {10, 10, 5}, 8);
  add_box(v, {-5, -5, 4.5}, {15, 15, 9}, 10);
  const Penetration p = penetration(v, at_rest(v));
  EXPECT_NEAR(p.max_mm, 0.5, 2e-3);  // straight through, both ways
  // The small box's top and the part of the large one's bottom above it lie in the other; 98 % of all is outside.
  EXPECT_GT(p.overlapping_mm2, 2 * 100 * 0.9);
  EXPECT_LT(p.overlapping_mm2, 2 * 100 * 1.1 + 40 * 0.5);
  EXPECT_NEAR(p.area_mm2, 2 * 100 + 4 * 50 + 2 * 400 + 4 * 90, 1e-6);
  EXPECT_NEAR(winding_number(v, at_rest(v), {5, 5, 4.75}), 2, 1e-5);
  EXPECT_NEAR(winding_number(v, at_rest(v), {5, 5, 2}), 1, 1e-5);
  EXPECT_NEAR(winding_number(v, at_rest(v), {5, 5, -2}), 0, 1e-5);
}

TEST(Penetration, NothingWhereSurfacesJustMeetOrStandApart) {
  for (const double gap : {0.0, 0.5}) {
    SurfaceView v;
    add_box(v, {0, 0, 0}, {10, 10, 5}, 8);
    add_box(v, {0, 0, 5 + gap}, {10, 10, 10}, 8);
    const Penetration p = penetration(v, at_rest(v));
    EXPECT_LT(p.max_mm, 3e-3);
    EXPECT_EQ(p.overlapping_mm2, 0);
  }
  SurfaceView v;
  add_box(v, {0, 0, 0}, {10, 10, 5}, 4, FaceKind::skin);
  EXPECT_EQ(penetration(v, at_rest(v)).area_mm2, 0) << "no wall, nothing to look at";
}

TEST(Penetration, ASlantedOverlapIsReadAlongTheShortestWay) {
  // A wedge whose slanted side cuts into a box: the depth of a point is its distance to the box's side.
  SurfaceView v;
  add_box(v, {0, 0, 0}, {20, 20, 6}, 12);
  const size_t first = v.X_mm.size();
  add_box(v, {2, 2, 5.2}, {18, 18, 9}, 12);
  std::vector<Vec3f> x = at_rest(v);
  for (size_t i = first; i < x.size(); ++i)
    x[i].z() += 0.08f * (x[i].x() - 10);  // its bottom from 0.14 above to 1.44 below z = 6
  const Penetration p = penetration(v, x);
  EXPECT_NEAR(p.max_mm, 1.44, 0.12);  // places are about 1 mm apart
  EXPECT_LE(p.max_mm, 1.445);
}

TEST(Penetration, RaysAndSolidAnglesAgree) {
  SurfaceView v;
  test::Random r(9);
  for (int k = 0; k < 6; ++k) {
    const Vec3 c = r.vector(4);
    add_box(v, c - Vec3(2, 3, 1.5), c + Vec3(2, 3, 1.5), 2);
  }
  const std::vector<Vec3f> x = at_rest(v);
  std::vector<Vec3> xd;
  for (const Vec3f& p : x) xd.push_back(p.cast<double>());
  int doubled = 0;
  for (int k = 0; k < 300; ++k) {
    const Vec3 p = r.vector(5);
    int boxes = 0;
    for (int b = 0; b < 6; ++b) {
      const Vec3 lo = xd[size_t(b) * xd.size() / 6].cwiseMin(xd[(size_t(b) + 1) * xd.size() / 6 - 1]);
      const Vec3 hi = xd[size_t(b) * xd.size() / 6].cwiseMax(xd[(size_t(b) + 1) * xd.size() / 6 - 1]);
      boxes += (p.array() > lo.array()).all() && (p.array() < hi.array()).all();
    }
    EXPECT_NEAR(winding_number(v, x, p), boxes, 1e-4);
    doubled += boxes > 1;
  }
  EXPECT_GT(doubled, 10);
}

}  // namespace test_penetration
}  // namespace limberg
