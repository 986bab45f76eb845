// The hierarchy answers as brute force over all triangles does.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "sim/body/block.h"
#include "sim/geometry/bvh.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace test_bvh {

Body small_block() {
  BlockSpec s;
  s.size_mm = {20, 16, 6};
  s.skin_cell_mm = 2;
  return make_block(s);
}

Vec3 random_point(std::mt19937_64& rng) {
  std::uniform_real_distribution<double> u(-15, 15);
  return {u(rng), u(rng), u(rng)};
}

void expect_closest_like_brute_force(const Bvh& bvh, const std::vector<Vec3>& x, const std::vector<Tri>& tri,
                                     const Vec3& p) {
  double best = 1e300;
  int32_t lowest = -1;
  for (size_t i = 0; i < tri.size(); ++i) {
    const Tri& t = tri[i];
    const double d2 =
        (closest_on_triangle(p, x[size_t(t[0])], x[size_t(t[1])], x[size_t(t[2])]).point - p).squaredNorm();
    if (d2 < best) best = d2, lowest = int32_t(i);
  }
  const auto c = bvh.closest(p);
  EXPECT_EQ(c.triangle, lowest);
  ASSERT_GE(c.triangle, 0);
  EXPECT_EQ(c.distance_mm, std::sqrt(best));
  Vec3 q = Vec3::Zero();
  for (size_t k = 0; k < 3; ++k) q += c.bary[k] * x[size_t(tri[size_t(c.triangle)][k])];
  EXPECT_LT((q - c.point_mm).norm(), 1e-15 * (40 + p.norm()) * 40);  // a few ulps of the coordinates
}

TEST(ClosestOnTriangle, IsOptimal) {
  // The residual p - q must make no acute angle with any direction from q into the triangle.
  std::mt19937_64 rng(1);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 a = random_point(rng), b = random_point(rng), c = random_point(rng), p = random_point(rng);
    const TrianglePoint q = closest_on_triangle(p, a, b, c);
    for (const Vec3& corner : {a, b, c}) EXPECT_LE((p - q.point).dot(corner - q.point), 1e-9);
  }
}

TEST(Bvh, ClosestMatchesBruteForceBeforeAndAfterRefit) {
  const Body b = small_block();
  Bvh bvh(b.surface.X_mm, b.surface.tri);
  EXPECT_EQ(bvh.triangles(), b.surface.tri.size());
  std::mt19937_64 rng(2);
  for (int n = 0; n < 300; ++n) expect_closest_like_brute_force(bvh, b.surface.X_mm, b.surface.tri, random_point(rng));
  std::vector<Vec3> x = b.surface.X_mm;
  for (Vec3& p : x) p = Vec3(p.x() * 1.3, p.y() + 0.1 * p.x() * p.x(), p.z() + std::sin(p.y()));
  bvh.refit(x);
  for (int n = 0; n < 300; ++n) expect_closest_like_brute_force(bvh, x, b.surface.tri, random_point(rng));
  std::vector<Vec3f> xf;
  for (Vec3& p : x) xf.push_back(p.cast<float>()), p = xf.back().cast<double>();
  bvh.refit(xf);
  for (int n = 0; n < 100; ++n) expect_closest_like_brute_force(bvh, x, b.surface.tri, random_point(rng));
}

// Above corners and edges several triangles are equally near, and on the surface the distance is nothing; farther from
// the origin floats say less of it.
TEST(Bvh, OfTrianglesEquallyNearTheFirstIsTaken) {
  const Body b = small_block();
  for (const double far : {0.0, 7777.7}) {
    std::vector<Vec3> x = b.surface.X_mm;
    for (Vec3& p : x) p += Vec3::Constant(far);
    const Bvh bvh(x, b.surface.tri);
    for (size_t v = 0; v < x.size(); v += 3)
      for (const Vec3& by : {Vec3(0, 0, 0), Vec3(0, 0, 3), Vec3(-1, 2, 0.1), Vec3(1, 0, 0)})
        expect_closest_like_brute_force(bvh, x, b.surface.tri, x[v] + by);
  }
}

TEST(Bvh, ClosestRespectsTheDistanceAndTheSubset) {
  const Body b = small_block();
  std::vector<int32_t> skin;
  for (size_t t = 0; t < b.surface.tri.size(); ++t)
    if (b.surface.tag[t] == SurfaceTag::skin) skin.push_back(int32_t(t));
  const Bvh bvh(b.surface.X_mm, b.surface.tri, skin);
  EXPECT_EQ(bvh.closest({0, 0, 3}, 2.9).triangle, -1);
  const auto c = bvh.closest({0.3, 0.2, -5}, 100);
  EXPECT_DOUBLE_EQ(c.distance_mm, 5);
  EXPECT_EQ(b.surface.tag[size_t(c.triangle)], SurfaceTag::skin);
}

TEST(Bvh, LinesCrossAClosedSurfaceInAndOut) {
  const Body b = small_block();
  const Bvh bvh(b.surface.X_mm, b.surface.tri);
  std::mt19937_64 rng(3);
  for (int n = 0; n < 500; ++n) {
    const Vec3 o = random_point(rng), d = random_point(rng);
    const auto hits = bvh.line(o, d, -1e6, 1e6);
    int inside = 0;
    for (const auto& h : hits) {
      inside += h.from_outside ? 1 : -1;
      EXPECT_TRUE(inside == 0 || inside == 1);
    }
    EXPECT_EQ(inside, 0);
    EXPECT_TRUE(std::is_sorted(hits.begin(), hits.end(), [](auto& p, auto& q) { return p.t < q.t; }));
    std::array<Bvh::LineHit, 1> first;
    EXPECT_EQ(bvh.line(o, d, -1e6, 1e6, first), int(hits.size()));
    if (!hits.empty()) {
      EXPECT_EQ(first[0].triangle, hits[0].triangle);
    }
  }
}

TEST(Bvh, LinesThroughVerticesAndEdgesNeverSlipThrough) {
  const Body b = small_block();
  const Bvh bvh(b.surface.X_mm, b.surface.tri);
  for (const Vec3& X : b.surface.X_mm) {
    const auto hits = bvh.line({X.x(), X.y(), 50}, -Vec3::UnitZ(), 0, 1e6);
    ASSERT_FALSE(hits.empty());
    EXPECT_NEAR(hits[0].t, 50, 1e-12 * 50);
    EXPECT_TRUE(hits[0].from_outside);
  }
}

TEST(Bvh, BoxQueryFindsExactlyTheTrianglesWhoseBoxesMeet) {
  const Body b = small_block();
  const Bvh bvh(b.surface.X_mm, b.surface.tri);
  std::mt19937_64 rng(4);
  for (int n = 0; n < 100; ++n) {
    const Vec3 p = random_point(rng), q = random_point(rng), lo = p.cwiseMin(q), hi = p.cwiseMax(q);
    std::vector<int32_t> got, want;
    bvh.box(lo, hi, [&](int32_t t) { got.push_back(t); });
    for (size_t t = 0; t < b.surface.tri.size(); ++t) {
      Vec3 a = b.surface.X_mm[size_t(b.surface.tri[t][0])], z = a;
      for (int32_t v : b.surface.tri[t])
        a = a.cwiseMin(b.surface.X_mm[size_t(v)]), z = z.cwiseMax(b.surface.X_mm[size_t(v)]);
      if ((a.array() <= hi.array()).all() && (z.array() >= lo.array()).all()) want.push_back(int32_t(t));
    }
    std::sort(got.begin(), got.end());
    EXPECT_EQ(got, want);
  }
}

}  // namespace test_bvh
}  // namespace limberg
