#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "sim/geometry/polyline.h"

namespace limberg {
namespace test_polyline {

TEST(Polyline, LengthInThePlaneAndInSpace) {
  EXPECT_EQ(path_length(std::vector<Vec2>{}), 0);
  EXPECT_EQ(path_length(std::vector<Vec2>{{5, 7}}), 0);
  EXPECT_DOUBLE_EQ(path_length(std::vector<Vec2>{{0, 0}, {3, 4}, {3, 6}}), 7);
  EXPECT_DOUBLE_EQ(path_length(std::vector<Vec3>{{0, 0, 0}, {2, 3, 6}, {2, 3, 7}}), 8);
}

TEST(Polyline, AreaHasTheSignOfTheTurn) {
  const std::vector<Vec2> l{{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {0, 3}}, back(l.rbegin(), l.rend());
  EXPECT_DOUBLE_EQ(signed_area(l), 6);
  EXPECT_DOUBLE_EQ(signed_area(back), -6);
}

// A star-shaped polygon: inside is what lies nearer to its middle than the outline does in that direction.
TEST(Polyline, InsideAStarIsBelowItsRadius) {
  constexpr int n = 37;
  const auto radius = [](int k) { return k % 2 ? 3.0 : 8.0; };
  std::vector<Vec2> star;
  for (int k = 0; k < n; ++k) {
    const double a = 2 * std::numbers::pi * k / n;
    star.push_back(radius(k) * Vec2(std::cos(a), std::sin(a)));
  }
  const std::vector<Vec2> back(star.rbegin(), star.rend());
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-9, 9);
  int in = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec2 p(place(random), place(random));
    const double turn = (std::atan2(p.y(), p.x()) / (2 * std::numbers::pi) + 1) * n;
    const auto k = size_t(turn);
    const Vec2 a = star[k % n], b = star[(k + 1) % n];
    const double side = cross2(b - a, p - a);  // to the left of the edge that its direction meets
    if (std::abs(side) < 1e-6) continue;
    EXPECT_EQ(inside_polygon(star, p), side > 0) << p.transpose();
    EXPECT_EQ(inside_polygon(back, p), side > 0) << "the turn does not count";
    in += side > 0;
  }
  EXPECT_GT(in, 3000);
  EXPECT_LT(in, 17000);
  EXPECT_FALSE(inside_polygon({}, Vec2(0, 0)));
}

TEST(Polyline, DistanceToASegment) {
  const Vec2 a(1, 1), b(5, 1);
  EXPECT_DOUBLE_EQ(distance_to_segment(Vec2(3, 4), a, b), 3);
  EXPECT_DOUBLE_EQ(distance_to_segment(Vec2(-2, 5), a, b), 5);
  EXPECT_DOUBLE_EQ(distance_to_segment(Vec2(8, 5), a, b), 5);
  EXPECT_DOUBLE_EQ(distance_to_segment(Vec2(4, 5), a, a), 5);
  EXPECT_FLOAT_EQ(distance_to_segment(Vec3f(0, 2, 2), Vec3f(-1, 0, 2), Vec3f(1, 0, 2)), 2);
}

TEST(Polyline, WhereSegmentsMeet) {
  EXPECT_DOUBLE_EQ(meet_segments({0, 0}, {4, 0}, {1, -1}, {1, 1}).value(), 0.25);
  EXPECT_FALSE(meet_segments({0, 0}, {4, 0}, {5, -1}, {5, 1}));
  EXPECT_FALSE(meet_segments({0, 0}, {4, 0}, {0, 1}, {4, 1})) << "parallel";
}

TEST(Polyline, CornersStayAndTremorGoes) {
  std::vector<Vec2> drawn;
  for (int i = 0; i <= 40; ++i) drawn.push_back({0.25 * i, i % 2 ? 0.1 : -0.1});
  for (int i = 1; i <= 40; ++i) drawn.push_back({10 + (i % 2 ? 0.1 : -0.1), 0.25 * i});
  const std::vector<Vec2> kept = simplify(drawn, 0.3);
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_EQ(kept.front(), drawn.front());
  EXPECT_EQ(kept.back(), drawn.back());
  EXPECT_LT((kept[1] - Vec2(10, 0)).norm(), 0.3);
  for (const Vec2& p : drawn)
    EXPECT_LE(std::min(distance_to_segment(p, kept[0], kept[1]), distance_to_segment(p, kept[1], kept[2])), 0.3);
  EXPECT_EQ(simplify(drawn, 0).size(), drawn.size());
  EXPECT_TRUE(simplify(std::span<const Vec2>(), 1).empty());
  // In space as in the plane.
  const std::vector<Vec3> bent{{0, 0, 1}, {1, 0.01, 1}, {2, 0, 1}, {2, 0, 3}};
  EXPECT_EQ(simplify(bent, 0.1), (std::vector<Vec3>{bent[0], bent[2], bent[3]}));

  // Only between the two points asked for.
  std::vector<uint8_t> keep(drawn.size(), 0);
  keep_corners(drawn, 0, 20, 0.01, keep);
  for (size_t i = 1; i < 20; ++i) EXPECT_EQ(keep[i], 1) << i;
  for (size_t i = 20; i < keep.size(); ++i) EXPECT_EQ(keep[i], 0) << i;
}

}  // namespace test_polyline
}  // namespace limberg
