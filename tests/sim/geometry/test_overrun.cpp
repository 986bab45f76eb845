// Where an outline is closed whose end runs on beyond its beginning.
#include <gtest/gtest.h>

#include <vector>

#include "sim/geometry/overrun.h"

namespace limberg {
namespace test_overrun {

std::vector<Vec2> dense(const std::vector<Vec2>& way, double step_mm) {
  std::vector<Vec2> out;
  for (size_t i = 0; i + 1 < way.size(); ++i) {
    const int n = std::max(1, int((way[i + 1] - way[i]).norm() / step_mm));
    for (int k = 0; k < n; ++k) out.push_back(way[i] + (way[i + 1] - way[i]) * (double(k) / n));
  }
  out.push_back(way.back());
  return out;
}

TEST(Overrun, WhatRunsOnIsCutOffInCornersAsInADenseWay) {
  const std::vector<Vec2> square{{0, 0}, {20, 0}, {20, 10}, {0, 10}};
  for (const double beyond : {0.2, 0.6, 3.0, 9.0})
    for (const Vec2& aside : {Vec2(0, 0), Vec2(0.5, 0), Vec2(-0.5, 0)}) {
      std::vector<Vec2> corners = square;
      corners[3] += aside;
      corners.push_back(Vec2(0, -beyond) + aside);
      EXPECT_EQ(points_to_closing(corners), 4u) << beyond << " mm beyond, " << aside.x() << " mm aside";
      if (beyond < 0.5) continue;  // of a hand's points the last one may be the nearest
      const std::vector<Vec2> drawn = dense(corners, 0.4);
      const size_t left = points_to_closing(drawn);
      ASSERT_LT(left, drawn.size());
      EXPECT_LT((drawn[left - 1] - Vec2(0, 0)).norm(), 0.75);
    }
  // Along its own first edge.
  std::vector<Vec2> on{{5, 0}, {20, 0}, {20, 10}, {0, 10}, {0, 0.3}, {7, 0.3}};
  EXPECT_EQ(points_to_closing(on), 5u);
}

TEST(Overrun, NothingElseIsTouched) {
  const std::vector<Vec2> square{{0, 0}, {20, 0}, {20, 10}, {0, 10}};
  EXPECT_EQ(points_to_closing(square), 4u);
  std::vector<Vec2> closed = square;
  closed.push_back({0, 0});
  EXPECT_EQ(points_to_closing(closed), 5u) << "a repeated first point";
  closed.back() = {0, 0.6};
  EXPECT_EQ(points_to_closing(closed), 5u) << "it ends before its beginning";
  // More than kRunsOn_mm, or farther aside than kPasses_mm: that is no slip of a hand.
  EXPECT_EQ(points_to_closing(std::vector<Vec2>{{0, 0}, {20, 0}, {20, 10}, {0, 10}, {0, -11}}), 5u);
  EXPECT_EQ(points_to_closing(std::vector<Vec2>{{0, 0}, {20, 0}, {20, 10}, {-1.4, 10}, {-1.4, -3}}), 5u);
  EXPECT_EQ(points_to_closing(std::vector<Vec2>{}), 0u);
  EXPECT_EQ(points_to_closing(std::vector<Vec2>(7, Vec2(1, 1))), 7u);
}

}  // namespace test_overrun
}  // namespace limberg
