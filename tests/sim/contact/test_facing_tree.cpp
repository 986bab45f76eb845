// The tree against looking at every triangle, and who counts as whose neighbour.
#include "sim/contact/facing_tree.h"

#include <gtest/gtest.h>

#include "../fem/models.h"
#include "sim/contact/neighbours.h"

namespace limberg {
namespace {

/// Two wavy sheets of n x n squares of 1 mm, the upper one `apart_mm` above and turned over, so that they face each other.
void sheets(int n, double apart_mm, std::vector<Vec3>& X, std::vector<Tri>& tri) {
  for (int sheet = 0; sheet < 2; ++sheet) {
    const int32_t base = int32_t(X.size());
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) X.push_back({double(i), double(j), 0.3 * std::sin(0.7 * i) + sheet * apart_mm});
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int32_t a = base + j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
        for (Tri t : {Tri{a, b, d}, Tri{a, d, c}}) {
          if (sheet == 1) std::swap(t[1], t[2]);
          tri.push_back(t);
        }
      }
  }
}

TEST(FacingTree, FindsWhatLookingAtEveryTriangleFinds) {
  std::vector<Vec3> X;
  std::vector<Tri> tri;
  sheets(12, 0.4, X, tri);
  FacingTree tree(X, tri);
  test::Random r(3);
  std::vector<Vec3> x;
  for (const Vec3& p : X) x.push_back(p + r.vector(0.15));
  tree.refit(x);
  int found = 0;
  for (int k = 0; k < 400; ++k) {
    FacingTree::Query q;
    q.p_mm = Vec3(6, 6, 0.3) + Vec3(6 * r.uniform(), 6 * r.uniform(), r.uniform());
    q.n = r.vector(1).normalized();
    q.within_mm = 0.2 + 0.8 * std::abs(r.uniform());
    int32_t best = -1;
    double best2 = q.within_mm * q.within_mm;
    for (int32_t t = 0; t < int32_t(tri.size()); ++t) {
      if (!(tree.normal(t).dot(q.n) < -0.2) || t % 7 == 3) continue;
      const Tri& c = tri[size_t(t)];
      const double d2 = (closest_on_triangle(q.p_mm, x[size_t(c[0])], x[size_t(c[1])], x[size_t(c[2])]).point - q.p_mm).squaredNorm();
      if (d2 < best2 || (d2 == best2 && best < 0)) best2 = d2, best = t;
    }
    const auto accept = [](int32_t t, const std::array<double, 3>&) { return t % 7 != 3; };
    const FacingTree::Foot a = tree.nearest(q, accept);
    EXPECT_EQ(a.triangle, best);
    q.guess = int32_t(tri.size() / 2) + k % 100;  // the answer does not depend on where the search begins
    EXPECT_EQ(tree.nearest(q, accept).triangle, best);
    found += best >= 0;
  }
  EXPECT_GT(found, 100);
  EXPECT_LT(found, 400);
}

/// A surface of given corners and triangles with one place in the middle of triangle 0.
std::shared_ptr<ContactSurface> surface_of(std::vector<Vec3> X, std::vector<Tri> tri) {
  auto s = std::make_shared<ContactSurface>();
  s->X_mm = std::move(X), s->tri = std::move(tri);
  s->around_begin.assign(s->X_mm.size() + 1, 0);
  for (size_t v = 0; v < s->X_mm.size(); ++v) {
    for (size_t t = 0; t < s->tri.size(); ++t)
      if (std::find(s->tri[t].begin(), s->tri[t].end(), int32_t(v)) != s->tri[t].end()) s->around.push_back(int32_t(t));
    s->around_begin[v + 1] = int32_t(s->around.size());
  }
  s->place.resize(1);
  return s;
}

TEST(Neighbours, BanksOfACutAreOthersAndTheSidesOfATipAreNot) {
  // Triangle 0: a wall that looks to +x. 1: its mate at the same place, looking to -x. 2: joined to 0 along the upright edge
  // at y = 0, turned back by 60 degrees: the other side of a tip. 3: the floor, joined to 0 at its foot. 4: a floor joined to
  // nothing. 5: the wall of a strip 3 mm wide, behind 0 and looking away. 6: far away.
  const double s = std::sin(M_PI / 3), c = std::cos(M_PI / 3);
  const auto surface = surface_of({{0, 0, 0}, {0, 2, 0}, {0, 0, 2},            // 0
                                   {0, 0, 0}, {0, 2, 0}, {0, 0, 2},            // 1
                                   {-2 * s, 2 * c, 0},                         // 2 with corners 0 and 2
                                   {1.5, 1, 0},                                // 3 with corners 0 and 1
                                   {0.1, 0, -0.1}, {0.1, 2, -0.1}, {2, 1, -0.1},
                                   {-3, 0, 0}, {-3, 2, 0}, {-3, 0, 2},
                                   {30, 0, 0}, {30, 2, 0}, {30, 0, 2}},
                                  {{0, 1, 2}, {3, 5, 4}, {0, 2, 6}, {0, 7, 1}, {8, 10, 9}, {11, 13, 12}, {14, 15, 16}});
  Neighbours n(surface);
  const auto normal = [&](int32_t t) {
    const Tri& v = surface->tri[size_t(t)];
    return area_vector2(surface->X_mm[size_t(v[0])], surface->X_mm[size_t(v[1])], surface->X_mm[size_t(v[2])]).normalized();
  };
  const Neighbours::Place place{0, 0, surface->rest_mm(0, {1.0 / 3, 1.0 / 3, 1.0 / 3}), normal(0)};
  const auto other = [&](int32_t t, std::array<double, 3> bary = {0.3, 0.3, 0.4}) { return n.other(place, t, surface->rest_mm(t, bary), normal(t)); };
  ASSERT_NEAR(normal(0).x(), 1, 1e-12);
  EXPECT_FALSE(other(0, {0.8, 0.1, 0.1})) << "itself";
  EXPECT_TRUE(other(1)) << "the other bank";
  EXPECT_TRUE(other(1, {1.0 / 3, 1.0 / 3, 1.0 / 3})) << "the other bank, at the very place";
  EXPECT_FALSE(other(2)) << "the other side of the tip";
  EXPECT_FALSE(other(2, {0.5, 0.5, 0})) << "the tip's edge";
  EXPECT_FALSE(other(3)) << "the floor that it stands on";
  EXPECT_TRUE(other(4)) << "a floor below a cut";
  EXPECT_TRUE(other(6)) << "far away";
  EXPECT_FALSE(other(5)) << "the far side of a strip";
}

}  // namespace
}  // namespace limberg
