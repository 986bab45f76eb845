// The tree against looking at every triangle, and who counts as whose neighbour.
#include "sim/contact/facing_tree.h"

#include <gtest/gtest.h>

#include <tuple>

#include "../fem/models.h"
#include "sim/contact/neighbours.h"
#include "sim/contact/sheets.h"

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

// Four sheets, two wavy ones that face each other, each halved; the answers of both walks against looking at every triangle.
TEST(FacingTree, FindsWhatLookingAtEveryTriangleFinds) {
  std::vector<Vec3> X;
  std::vector<Tri> tri;
  sheets(12, 0.4, X, tri);
  std::vector<int32_t> sheet;
  for (size_t t = 0; t < tri.size(); ++t) sheet.push_back(int32_t(4 * t / tri.size()));
  FacingTree tree(X, tri, sheet);
  test::Random r(3);
  std::vector<Vec3> x;
  for (const Vec3& p : X) x.push_back(p + r.vector(0.15));
  InlineWorkers workers;
  tree.refit(x, workers);
  const auto squared = [&](const Vec3& p, int32_t t, Vec3& apart) {
    const Tri& c = tri[size_t(t)];
    apart = p - closest_on_triangle(p, x[size_t(c[0])], x[size_t(c[1])], x[size_t(c[2])]).point;
    return apart.squaredNorm();
  };
  int found = 0, both = 0;
  for (int k = 0; k < 400; ++k) {
    FacingTree::Query q;
    q.p_mm = Vec3(6, 6, 0.3) + Vec3(6 * r.uniform(), 6 * r.uniform(), r.uniform());
    q.n = r.vector(1).normalized();
    q.near_mm = 0.2 + 0.3 * std::abs(r.uniform()), q.deep_mm = 1.5;
    std::vector<std::tuple<double, int32_t, int32_t>> best(4, {1e9, -1, -1});
    size_t around = 0;
    Vec3 apart;
    for (int32_t t = 0; t < int32_t(tri.size()); ++t) {
      const double d2 = squared(q.p_mm, t, apart);
      around += d2 <= 0.3 * 0.3;
      if (!(tree.normal(t).dot(q.n) < -0.1) || t % 7 == 3 || d2 > std::pow(apart.dot(q.n) >= 0 ? q.deep_mm : q.near_mm, 2)) continue;
      if (d2 < std::get<0>(best[size_t(sheet[size_t(t)])])) best[size_t(sheet[size_t(t)])] = {d2, sheet[size_t(t)], t};
    }
    std::erase_if(best, [](const auto& b) { return std::get<2>(b) < 0; });
    std::sort(best.begin(), best.end());
    const auto accept = [](int32_t t, const std::array<double, 3>&) { return t % 7 != 3; };
    const std::array<int32_t, 2> guess{int32_t(tri.size() / 2) + k % 100, k % 90};
    for (const bool guessed : {false, true}) {  // the answer does not depend on where the search begins
      FacingTree::Feet feet;
      if (guessed) q.guess = guess;
      ASSERT_EQ(tree.nearest(q, accept, feet), best.size());
      for (size_t i = 0; i < best.size(); ++i) {
        EXPECT_EQ(feet[i].triangle, std::get<2>(best[i]));
        EXPECT_NEAR(feet[i].distance_mm, std::sqrt(std::get<0>(best[i])), 1e-12);
      }
    }
    size_t met = 0;
    tree.near(q.p_mm, 0.3, [&](int32_t t, const TrianglePoint&, double d2) { met += std::abs(d2 - squared(q.p_mm, t, apart)) < 1e-12; });
    EXPECT_EQ(met, around);
    found += !best.empty(), both += best.size() > 1;
  }
  EXPECT_GT(found, 100);
  EXPECT_LT(found, 400);
  EXPECT_GT(both, 20);
}

// A slab's side and top, and a fold of 30 degrees in the top: two sheets that meet, and normals that turn within the top only.
TEST(Sheets, TurnSmoothlyAndEndAtSharpEdges) {
  const double s = std::sin(M_PI / 6), c = std::cos(M_PI / 6);
  const auto surface = surface_of({{0, 0, 0}, {0, 4, 0}, {2, 0, 0}, {2, 4, 0}, {2 + 2 * c, 0, -2 * s}, {2 + 2 * c, 4, -2 * s}, {0, 0, -2}, {0, 4, -2}},
                                  {{0, 2, 3}, {0, 3, 1}, {2, 4, 5}, {2, 5, 3}, {6, 0, 1}, {6, 1, 7}});
  const std::vector<uint8_t> wall(6, 3), mixed{3, 3, 0, 0, 3, 3};
  const Sheets a = find_sheets(surface->X_mm, surface->tri, wall, surface->around_begin, surface->around);
  EXPECT_EQ(a.of, (std::vector<int32_t>{0, 0, 0, 0, 1, 1}));
  EXPECT_TRUE(a.adjacent(1, 0));
  EXPECT_FALSE(a.adjacent(0, 0));
  EXPECT_EQ(a.fan[0][1], a.fan[2][0]) << "vertex 2 has one fan across the fold";
  EXPECT_EQ(a.triangles_of_fan(a.fan[0][1]).size(), 3u);
  EXPECT_NE(a.fan[0][0], a.fan[4][1]) << "vertex 0 has two";
  const Sheets b = find_sheets(surface->X_mm, surface->tri, mixed, surface->around_begin, surface->around);
  EXPECT_EQ(b.of, (std::vector<int32_t>{0, 0, 1, 1, 2, 2})) << "skin and wall are never one sheet";
  EXPECT_EQ(b.meet, (std::vector<std::pair<int32_t, int32_t>>{{0, 1}, {0, 2}}));
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
