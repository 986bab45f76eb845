// Strokes of the scalpel told in pieces while they are drawn.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "devices/command_builder.h"
#include "sim/commands/strokes.h"

namespace limberg {
namespace test_drawing {

ToolEvent event(int kind, const ChartPoint& p) {
  ToolEvent e;
  e.kind = kind;
  e.tool = int32_t(Tool::scalpel);
  e.chart_x = p.x(), e.chart_y = p.y();
  e.depth_mm = 4, e.angle_deg = 80;
  return e;
}

/// A hand along a path with tremor, as gestures tell it: a point each 0.4 mm.
std::vector<ChartPoint> by_hand(const std::vector<ChartPoint>& path, double tremor_mm) {
  std::mt19937_64 rng(5);
  const auto noise = [&] { return tremor_mm * (2 * double(rng() >> 11) / 9007199254740992.0 - 1); };
  std::vector<ChartPoint> out{path[0]};
  for (size_t i = 1; i < path.size(); ++i) {
    const int n = int(std::ceil((path[i] - path[i - 1]).norm() / 0.4));
    for (int k = 1; k <= n; ++k) out.push_back(path[i - 1] + (path[i] - path[i - 1]) * k / n + Vec2(noise(), noise()));
  }
  return out;
}

std::vector<Command> build(const std::vector<ChartPoint>& points, CommandBuilder& builder,
                           double* largest_lag = nullptr) {
  std::vector<Command> out;
  double drawn = 0, told = 0;
  const auto take = [&](std::optional<Command> c) {
    if (!c) return;
    if (const auto* m = std::get_if<InciseMore>(&*c)) told = (m->path.back() - points[0]).norm();
    out.push_back(std::move(*c));
  };
  take(builder.feed(event(ToolEvent::stroke_begin, points[0])));
  for (size_t i = 1; i < points.size(); ++i) {
    drawn = (points[i] - points[0]).norm();
    take(builder.feed(event(ToolEvent::stroke_point, points[i])));
    if (largest_lag) *largest_lag = std::max(*largest_lag, drawn - told);
  }
  take(builder.feed(event(ToolEvent::stroke_end, points.back())));
  return out;
}

double distance(const ChartPoint& p, const std::vector<ChartPoint>& path) {
  double best = 1e300;
  for (size_t i = 1; i < path.size(); ++i) {
    const Vec2 d = path[i] - path[i - 1];
    const double t = std::clamp((p - path[i - 1]).dot(d) / d.squaredNorm(), 0.0, 1.0);
    best = std::min(best, (path[i - 1] + t * d - p).norm());
  }
  return best;
}

TEST(DrawnInPieces, FollowsTheHandAndItsCorners) {
  const std::vector<ChartPoint> path{{-20, 0}, {5, 2}, {9, -16}};
  CommandBuilder builder({}, true);
  const auto commands = build(by_hand(path, 0.15), builder);
  ASSERT_GE(commands.size(), 6u);
  for (size_t i = 0; i < commands.size(); ++i) {
    const auto& m = std::get<InciseMore>(commands[i]);
    EXPECT_EQ(m.stroke, 1);
    EXPECT_EQ(m.last, i + 1 == commands.size());
    EXPECT_EQ(m.depth_mm, 4);
    EXPECT_EQ(m.angle_deg, 80);
  }
  const auto whole = join_strokes(commands);
  ASSERT_EQ(whole.size(), 1u);
  const auto& drawn = std::get<Incise>(whole[0]).path;
  // Everything told lies on the path within tremor and the smoothing's tolerance (0.4 mm), and reaches all of it.
  for (const ChartPoint& p : drawn) EXPECT_LT(distance(p, path), 0.45);
  EXPECT_LT((drawn.front() - path.front()).norm(), 0.3);
  EXPECT_LT((drawn.back() - path.back()).norm(), 0.5);
  EXPECT_LT(distance(path[1], drawn), 0.6) << "the corner";
  for (size_t i = 1; i < drawn.size(); ++i) EXPECT_GT((drawn[i] - drawn[i - 1]).norm(), 0.05);
}

TEST(DrawnInPieces, IsNeverFarBehindTheHand) {
  CommandBuilder builder({}, true);
  double lag = 0;
  const auto commands = build(by_hand({{-30, 0}, {30, 3}}, 0.1), builder, &lag);
  EXPECT_GE(commands.size(), 10u);
  EXPECT_LT(lag, 5 + 2.5 + 0.4 + 0.3);  // a piece, what may be a corner, a step, tremor
}

TEST(DrawnInPieces, AShortStrokeIsOneIncision) {
  CommandBuilder builder({}, true);
  const auto commands = build(by_hand({{0, 0}, {6, 0}}, 0), builder);
  ASSERT_EQ(commands.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<Incise>(commands[0]));
  EXPECT_TRUE(build(by_hand({{0, 0}, {1, 0}}, 0), builder).empty());
  EXPECT_EQ(builder.dropped(), 1);
}

TEST(DrawnInPieces, AStoppedStrokeSaysNoMore) {
  CommandBuilder builder({}, true);
  const auto points = by_hand({{-20, 0}, {20, 0}}, 0.1);
  builder.feed(event(ToolEvent::stroke_begin, points[0]));
  size_t i = 1;
  while (!builder.feed(event(ToolEvent::stroke_point, points[i]))) ++i;
  builder.stop_stroke();
  for (; i < points.size(); ++i) EXPECT_FALSE(builder.feed(event(ToolEvent::stroke_point, points[i])));
  EXPECT_FALSE(builder.feed(event(ToolEvent::stroke_end, points.back())));
  // The next stroke has a number of its own.
  const auto next = build(points, builder);
  ASSERT_FALSE(next.empty());
  EXPECT_EQ(std::get<InciseMore>(next[0]).stroke, 2);
}

TEST(DrawnInPieces, OnlyWhenAskedFor) {
  CommandBuilder builder;
  const auto commands = build(by_hand({{-20, 0}, {20, 0}}, 0.1), builder);
  ASSERT_EQ(commands.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<Incise>(commands[0]));
}

}  // namespace test_drawing
}  // namespace limberg
