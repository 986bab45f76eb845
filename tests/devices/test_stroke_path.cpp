#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "devices/stroke_path.h"
#include "sim/geometry/polyline.h"
#include "tests/devices/samples.h"

namespace limberg {
namespace test_stroke_path {

using test::Dice;

/// Points every 0.45 mm along a polyline, with a 10 Hz tremor at 40 mm/s, noise, and jitter while waiting at corners.
std::vector<Vec2> drawn(const std::vector<Vec2>& path, double tremor_mm, double noise_mm, uint64_t seed) {
  Dice dice{seed};
  std::vector<Vec2> out;
  const double p1 = 6 * dice.unit(), p2 = 6 * dice.unit();
  double walked = 0;
  for (size_t i = 1; i < path.size(); ++i) {
    const double length = (path[i] - path[i - 1]).norm();
    for (double l = 0; l <= length; l += 0.45, walked += 0.45) {
      const double w = 2 * M_PI * 10 * walked / 40;
      out.push_back(path[i - 1] + l / length * (path[i] - path[i - 1]) +
                    Vec2(tremor_mm * std::sin(w + p1) + noise_mm * dice.normal(),
                         tremor_mm * std::sin(1.1 * w + p2) + noise_mm * dice.normal()));
    }
    for (int k = 0; k < 3; ++k) out.push_back(path[i] + 0.1 * Vec2(dice.normal(), dice.normal()));
  }
  return out;
}

std::vector<Vec2> rhombus(double side, double turn) {
  const double h = side * std::sqrt(3.0) / 2;
  std::vector<Vec2> p{{h, 0}, {0, side / 2}, {-h, 0}, {0, -side / 2}};
  for (Vec2& v : p) v = Eigen::Rotation2Dd(turn) * v;
  return p;
}

TEST(StrokePath, ARhombusDrawnWithTremorHasFourCorners) {
  double worst = 0;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const std::vector<Vec2> want = rhombus(20, 0.1 * double(seed));
    std::vector<Vec2> path = want;
    path.push_back(want[0]);
    const std::vector<Vec2> got = simplify_outline(drawn(path, 0.15, 0.05, seed));
    ASSERT_EQ(got.size(), 4u) << seed;
    for (const Vec2& w : want) {
      double nearest = 1e9;
      for (const Vec2& g : got) nearest = std::min(nearest, (g - w).norm());
      worst = std::max(worst, nearest);
    }
  }
  std::printf("  furthest corner %.3f mm\n", worst);
  EXPECT_LT(worst, 0.4);  // the tolerance; typical corners are better by far
}

TEST(StrokePath, AStartAnywhereAndAnOverlapDoNotMatter) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    const std::vector<Vec2> c = rhombus(24, 0.3);
    const Vec2 start = c[0] + 0.4 * (c[1] - c[0]), beyond = c[0] + 0.5 * (c[1] - c[0]);
    const std::vector<Vec2> got = simplify_outline(drawn({start, c[1], c[2], c[3], c[0], beyond}, 0.12, 0.05, seed));
    EXPECT_EQ(got.size(), 4u) << seed;
  }
}

TEST(StrokePath, OpenPathsKeepTheirEndsAndCorners) {
  const std::vector<Vec2> want{{0, 0}, {20, 0}, {30, 17.3}, {52, 17.3}};
  double worst = 0;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const std::vector<Vec2> got = simplify_path(drawn(want, 0.15, 0.05, seed));
    ASSERT_EQ(got.size(), want.size()) << seed;
    for (size_t i = 0; i < want.size(); ++i) worst = std::max(worst, (got[i] - want[i]).norm());
  }
  EXPECT_LT(worst, 0.5);
}

TEST(StrokePath, ACircleStaysRound) {
  std::vector<Vec2> circle;
  for (int i = 0; i <= 400; ++i)
    circle.push_back(15 * Vec2(std::cos(2 * M_PI * i / 400), std::sin(2 * M_PI * i / 400)));
  const std::vector<Vec2> got = simplify_outline(circle);
  EXPECT_GT(got.size(), 8u);
  EXPECT_LT(got.size(), 40u);
  for (const Vec2& p : got) EXPECT_NEAR(p.norm(), 15, 0.45);
  double area = 0;
  for (size_t i = 0; i < got.size(); ++i) {
    const Vec2 &a = got[i], &b = got[(i + 1) % got.size()];
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  EXPECT_NEAR(area / (M_PI * 225), 1, 0.03);
}

double to_path(const Vec2& q, const std::vector<Vec2>& path) {
  double nearest = 1e9;
  for (size_t i = 1; i < path.size(); ++i) nearest = std::min(nearest, distance_to_segment(q, path[i - 1], path[i]));
  return nearest;
}

/// The furthest that either lies beside the other, mm.
double apart(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  double furthest = 0;
  for (int way = 0; way < 2; ++way) {
    const std::vector<Vec2>&from = way ? b : a, &to = way ? a : b;
    for (size_t i = 1; i < from.size(); ++i)
      for (double t = 0; t <= 1; t += 0.125)
        furthest = std::max(furthest, to_path(from[i - 1] + t * (from[i] - from[i - 1]), to));
  }
  return furthest;
}

/// The path goes on as an arc to the left (below 0: to the right); a path of one point begins along x.
void arc(std::vector<Vec2>& path, double radius, double turn_deg) {
  const Vec2 begin = path.back();
  const Vec2 way = path.size() > 1 ? Vec2((begin - path[path.size() - 2]).normalized()) : Vec2(1, 0);
  const double side = turn_deg < 0 ? -1 : 1;
  const Vec2 middle = begin + side * radius * Vec2(-way.y(), way.x());
  for (int i = 1; i <= 60; ++i)
    path.push_back(middle + Eigen::Rotation2Dd(turn_deg * i / 60 * M_PI / 180) * (begin - middle));
}

/// A smooth stroke: `drawn` waits at corners only, and there are none between its ends.
std::vector<Vec2> drawn_smoothly(const std::vector<Vec2>& path, double tremor_mm, double noise_mm, uint64_t seed) {
  std::vector<Vec2> even{path[0]};
  double left = 0.45;
  for (size_t i = 1; i < path.size(); ++i) {
    Vec2 at = path[i - 1];
    for (double l; (l = (path[i] - at).norm()) >= left; left = 0.45)
      at += left / l * (path[i] - at), even.push_back(at);
    left -= (path[i] - at).norm();
  }
  even.push_back(path.back());
  Dice dice{seed};
  const double p1 = 6 * dice.unit(), p2 = 6 * dice.unit();
  for (size_t i = 0; i < even.size(); ++i) {
    const double w = 2 * M_PI * 10 * 0.45 * double(i) / 40;
    even[i] += Vec2(tremor_mm * std::sin(w + p1) + noise_mm * dice.normal(),
                    tremor_mm * std::sin(1.1 * w + p2) + noise_mm * dice.normal());
  }
  return even;
}

// Left to the polygons of their corners they lie .32 to .53 mm beside what was drawn, up to 1.24 mm at worst.
TEST(StrokePath, WhatIsDrawnAsACurveIsACurve) {
  std::vector<std::pair<const char*, std::vector<Vec2>>> drawings;
  for (const auto& [name, radius, turn] : {std::tuple{"semicircle of 4 mm", 4.0, 180.0},
                                           {"semicircle of 10 mm", 10.0, 180.0},
                                           {"three quarters of 8 mm", 8.0, 270.0},
                                           {"quarter of 25 mm", 25.0, 90.0},
                                           {"flat arc of 60 mm", 60.0, 30.0}}) {
    std::vector<Vec2> path{{0, 0}};
    arc(path, radius, turn);
    drawings.emplace_back(name, path);
  }
  std::vector<Vec2> s{{0, 0}};
  arc(s, 10, 120), arc(s, 8, -150);
  drawings.emplace_back("S", s);
  std::vector<Vec2> rotation{{0, 0}, {15, 0}};
  arc(rotation, 20, 100);
  drawings.emplace_back("line and arc", rotation);
  for (const auto& [name, path] : drawings) {
    double furthest = 0, mean = 0;
    size_t most = 0;
    for (uint64_t seed = 1; seed <= 100; ++seed) {
      const std::vector<Vec2> got = simplify_path(drawn_smoothly(path, 0.15, 0.05, seed));
      const double off = apart(got, path);
      furthest = std::max(furthest, off), mean += off / 100;
      most = std::max(most, got.size());
    }
    std::printf("  %-24s furthest %.3f mm, mean of 100 %.3f mm, up to %zu points\n", name, furthest, mean, most);
    EXPECT_LT(furthest, 0.4) << name;  // the tolerance
    EXPECT_LT(mean, 0.22) << name;     // tremor on both axes at once, 0.15 sqrt 2
  }
}

// Read as one curve of up to 2,000 spans: whatever is done for it must not grow with their square.
TEST(StrokePath, ACurveOfEightMetresIsRead) {
  std::vector<Vec2> spiral{{0, 0}};
  double length = 0;
  for (double a = 0.5; length < 8000; a += 0.05) {
    spiral.push_back(5 * a * Vec2(std::cos(a), std::sin(a)));
    length += (spiral.back() - spiral[spiral.size() - 2]).norm();
  }
  const std::vector<Vec2> got = simplify_path(drawn_smoothly(spiral, 0.15, 0.05, 1));
  EXPECT_LT(apart(got, spiral), 1.5 * PathSettings{}.tolerance_mm);  // as far as an edge may lie off its points
  std::printf("  %zu points of %.0f mm\n", got.size(), length);
}

TEST(StrokePath, CornersBetweenStraightEdgesStayWhereTheyAre) {
  for (const double turn : {20.0, 25.0, 35.0, 50.0, 70.0, 90.0, 120.0, 150.0}) {
    double furthest = 0, mean = 0;
    for (const double edge : {6.0, 10.0, 20.0})
      for (uint64_t seed = 1; seed <= 100; ++seed) {
        const Vec2 b(edge, 0), c = b + edge * Vec2(std::cos(turn * M_PI / 180), std::sin(turn * M_PI / 180));
        const std::vector<Vec2> path{{0, 0}, b, c}, got = simplify_path(drawn(path, 0.15, 0.05, seed));
        const double off = apart(got, path);
        furthest = std::max(furthest, off), mean += off / 300;
      }
    std::printf("  turn of %3.0f: furthest %.3f mm, mean of 300 %.3f mm\n", turn, furthest, mean);
    EXPECT_LT(furthest, 0.4) << turn;  // the tolerance
  }
}

TEST(StrokePath, StraightIsTwoPointsAndExactInputStaysExact) {
  std::vector<Vec2> line;
  for (int i = 0; i <= 50; ++i) line.push_back(Vec2(0.5 * i, 0.25 * i));
  const std::vector<Vec2> got = simplify_path(line);
  ASSERT_EQ(got.size(), 2u);
  EXPECT_LT((got[0] - line.front()).norm(), 1e-9);
  EXPECT_LT((got[1] - line.back()).norm(), 1e-9);
}

TEST(StrokePath, TurnedInputGivesTurnedOutput) {
  const std::vector<Vec2> p = drawn({{0, 0}, {20, 0}, {30, 17.3}}, 0.15, 0.05, 3);
  const Eigen::Rotation2Dd r(0.7);
  std::vector<Vec2> q;
  for (const Vec2& v : p) q.push_back(r * v + Vec2(5, -3));
  const auto a = simplify_path(p), b = simplify_path(q);
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_LT((r * a[i] + Vec2(5, -3) - b[i]).norm(), 1e-9);
}

TEST(StrokePath, NothingAndNonsense) {
  EXPECT_TRUE(simplify_path({}).empty());
  EXPECT_EQ(simplify_path({{1, 2}}).size(), 1u);
  EXPECT_EQ(simplify_path({{1, 2}, {1, 2}, {1, 2}}).size(), 1u);
  EXPECT_TRUE(simplify_path({{std::nan(""), 0}}).empty());
  EXPECT_EQ(simplify_outline({{0, 0}, {1, 0}}).size(), 2u);
  Dice dice{1};
  for (int k = 0; k < 2000; ++k) {
    std::vector<Vec2> p(dice.below(60));
    for (Vec2& v : p) v = Vec2(double(dice.below(4)), double(dice.below(4)));
    for (const Vec2& v : simplify_path(p)) ASSERT_TRUE(v.allFinite());
    for (const Vec2& v : simplify_outline(p)) ASSERT_TRUE(v.allFinite());
  }
}

TEST(StrokePath, InSpaceALineOnARoundBodyStaysOnIt) {
  // A cylinder of radius 30 about x; its normals on the way from -40 to 40 degrees.
  std::vector<Vec3> points, normals;
  for (int i = 0; i <= 80; ++i) {
    const double a = (i - 40) * std::numbers::pi / 180;
    normals.emplace_back(0, std::sin(a), std::cos(a));
    points.emplace_back(0.1 * i, 30 * std::sin(a), 30 * std::cos(a));
  }
  const std::vector<Vec3> path = simplify_in_space(points, normals, false);
  ASSERT_GE(path.size(), 2u);
  const double within = PathSettings{}.tolerance_mm;  // an end is its foot on the line of its edge
  EXPECT_LT((path.front() - points.front()).norm(), within);
  EXPECT_LT((path.back() - points.back()).norm(), within);
  for (const Vec3& p : path) {
    double off = 1e9;
    for (const Vec3& q : points) off = std::min(off, (p - q).norm());
    EXPECT_LT(off, 0.5) << p.transpose();  // half a step along, and the tolerance of the fit across
  }
}

TEST(StrokePath, InSpaceIsThatOfThePlaneWhicheverWayThePlaneLies) {
  std::vector<Vec2> flat;
  for (int i = 0; i <= 40; ++i) flat.emplace_back(0.25 * i, 0);
  for (int i = 1; i <= 40; ++i) flat.emplace_back(10, 0.25 * i);
  const std::vector<Vec2> want = simplify_path(flat);
  ASSERT_EQ(want.size(), 3u);
  for (const Vec3& n : {Vec3(0, 0, 1), Vec3(1, 2, -3), Vec3(0, -1, 0.2)}) {
    const Vec3 up = n.normalized(), e1 = up.unitOrthogonal(), e2 = up.cross(e1);
    std::vector<Vec3> points;
    for (const Vec2& p : flat) points.push_back(Vec3(5, 6, 7) + p.x() * e1 + p.y() * e2);
    const std::vector<Vec3> path = simplify_in_space(points, std::vector<Vec3>(points.size(), up), false);
    ASSERT_EQ(path.size(), 3u);
    for (size_t i = 0; i < 3; ++i)
      EXPECT_LT((path[i] - (Vec3(5, 6, 7) + want[i].x() * e1 + want[i].y() * e2)).norm(), 1e-9);
  }
  // Normals that cancel leave a plane that is as good as another; one point is itself.
  const std::vector<Vec3> two{Vec3(0, 0, 0), Vec3(10, 0, 0)};
  EXPECT_EQ(simplify_in_space(two, {Vec3::UnitZ(), -Vec3::UnitZ()}, false).size(), 2u);
  EXPECT_EQ(simplify_in_space({Vec3(1, 2, 3)}, {Vec3::UnitZ()}, false).size(), 1u);
}

}  // namespace test_stroke_path
}  // namespace limberg
