// Named cases at the level of strokes: what a hand draws again, further, deeper, across itself.
#include <random>

#include "tests/sim/cutting/patient.h"

namespace limberg::test {
namespace test_blade_cases {

const std::vector<Vec2> kLine{{-20, 1.3}, {20, 1.3}};

/// The line as a hand draws it again: off by up to `off`, with a tremor.
std::vector<Vec2> again(const std::vector<Vec2>& path, double off, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  std::vector<Vec2> out;
  const Vec2 shift = off * Vec2(u(random), u(random));
  for (const Vec2& p : resample(path, 0.4, false)) out.push_back(p + shift + 0.1 * Vec2(u(random), u(random)));
  return out;
}

TEST(BladeCases, Case19_RecutIsNothing) {
  Patient p(2);
  ASSERT_TRUE(p.incise(kLine).ok());
  for (unsigned seed = 1; seed <= 5; ++seed) {
    EXPECT_EQ(p.incise(again(kLine, 0.25, seed)).status, CutResult::nothing_to_cut);
    EXPECT_EQ(p.incise({{-13, 1.4}, {9, 1.2}}).status, CutResult::nothing_to_cut);
    EXPECT_EQ(p.incise({kLine[1], kLine[0]}).status, CutResult::nothing_to_cut);  // the other way round
  }
  EXPECT_EQ(p.a.operations(), 1);
}

TEST(BladeCases, Case20_ShallowerIsNothingDeeperOnlyExtends) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    Patient p(2);
    const auto line = [&](unsigned s) { return seed == 0 ? kLine : again(kLine, 0.12, s); };
    ASSERT_TRUE(p.incise(line(seed)).ok());
    EXPECT_EQ(p.incise(line(seed + 10), 2.5).status, CutResult::nothing_to_cut);
    const std::vector<int32_t> before = p.live_walls();
    const double area = p.wall_area();
    const size_t points = size_t(p.a.point_count());
    const CutResult deeper = p.incise(line(seed + 20), 7);
    ASSERT_TRUE(deeper.ok()) << deeper.reason;
    for (int32_t f : before) EXPECT_TRUE(p.a.faces()[f].live());  // not even divided
    EXPECT_EQ(p.a.pieces(), 1);
    EXPECT_EQ(euler(p.a), Chi{2});
    EXPECT_NEAR(p.wall_area() - area, 40 * 3, 3);  // nothing of the old wall is cut again
    // Only explicit points below the front were added: it crossed nothing.
    for (size_t i = points; i < size_t(p.a.point_count()); ++i) EXPECT_TRUE(p.a.is_explicit(int32_t(i)));
    ASSERT_TRUE(p.incise(line(seed + 30), 12).ok());  // and through
    EXPECT_EQ(p.a.pieces(), 1);
    while (p.a.undo()) ASSERT_EQ(p.a.check_all(), "");
  }
}

TEST(BladeCases, DeepenedInPartsIsAsDeepenedAtOnce) {
  Patient p(2), q(2);
  ASSERT_TRUE(p.incise(kLine, 3).ok());
  ASSERT_TRUE(p.incise({{-6, 1.3}, {6, 1.3}}, 6).ok());
  EXPECT_EQ(euler(p.a), Chi{2});
  ASSERT_TRUE(p.incise({{3, 1.3}, {14, 1.3}}, 5).ok());
  EXPECT_EQ(euler(p.a), Chi{2});
  ASSERT_TRUE(p.incise(kLine, 8).ok());
  EXPECT_EQ(euler(p.a), Chi{2});
  EXPECT_EQ(p.incise(kLine, 8).status, CutResult::nothing_to_cut);
  ASSERT_TRUE(q.incise(kLine, 8).ok());
  EXPECT_NEAR(p.wall_area(), q.wall_area(), 1e-2 * q.wall_area());
  EXPECT_NEAR(p.front_length(), q.front_length(), 0.5);  // no front is left between the parts
}

TEST(BladeCases, LengthenedSharesTheEndEdge) {
  for (const double depth : {4.0, 6.5, 2.5}) {
    for (const std::vector<Vec2>& next :
         {std::vector<Vec2>{{20, 1.3}, {34, 1.3}}, std::vector<Vec2>{{8, 1.2}, {34, 1.4}},
          std::vector<Vec2>{{20.4, 1.5}, {34, 8}}, std::vector<Vec2>{{34, 1.3}, {19.8, 1.1}},
          std::vector<Vec2>{{-34, 0}, {-19.7, 1.3}}, std::vector<Vec2>{{20, 1.3}, {20, 18}},
          std::vector<Vec2>{{20, 1.3}, {8, 14}}, std::vector<Vec2>{{-34, 1.3}, {34, 1.3}}}) {
      SCOPED_TRACE(testing::Message() << depth << " from " << next[0].transpose() << " to " << next[1].transpose());
      Patient p(2);
      ASSERT_TRUE(p.incise(kLine).ok());
      const double front = p.front_length();
      const CutResult r = p.incise(next, depth);
      ASSERT_TRUE(r.ok()) << r.reason;
      EXPECT_EQ(p.a.pieces(), 1);
      EXPECT_EQ(euler(p.a), Chi{2});
      // One front all around: at most the new foot and new end, and no end edge left inside.
      const double added = path_length(next);
      EXPECT_LT(p.front_length(), front + added + 2 * std::abs(depth - 4) + 1);
      while (p.a.undo()) ASSERT_EQ(p.a.check_all(), "");
    }
  }
}

TEST(BladeCases, Case37_ProgressiveStrokesSeparateOnlyAtTheEnd) {
  Patient p(2);
  const double y = 3.7;
  for (int i = 0; i < 13; ++i) {
    const double x = -52 + 8 * i;
    const CutResult r = p.incise({{std::max(x, -49.99), y}, {std::min(x + 8, 49.99), y + 0.01 * i}}, 12);
    ASSERT_TRUE(r.ok()) << i << r.reason;
    EXPECT_EQ(p.a.pieces(), 1) << i;
  }
}

TEST(BladeCases, FrontsThatOthersCrossedAreDeepened) {
  // The other order of X and deepening: the front is shared after a wall has crossed it.
  for (const double across : {2.0, 6.0, 9.0}) {
    SCOPED_TRACE(across);
    Patient p(2);
    ASSERT_TRUE(p.incise(kLine, 4).ok());
    ASSERT_TRUE(p.incise({{1, -15}, {3, 17}}, across).ok());
    ASSERT_TRUE(p.incise({{-12, -15}, {-9, 17}}, across).ok());
    EXPECT_EQ(euler(p.a), Chi{2});
    ASSERT_TRUE(p.incise(kLine, 7).ok());
    EXPECT_EQ(p.a.pieces(), 1);
    EXPECT_EQ(euler(p.a), Chi{2});
    ASSERT_TRUE(p.incise({{8, -15}, {6, 17}}, 8).ok());  // over the joint
    EXPECT_EQ(euler(p.a), Chi{2});
    EXPECT_EQ(p.incise(kLine, 7).status, CutResult::nothing_to_cut);
    ASSERT_TRUE(p.incise(kLine, 9).ok());
    EXPECT_EQ(euler(p.a), Chi{2});
    while (p.a.undo()) ASSERT_EQ(p.a.check_all(), "");
  }
}

TEST(BladeCases, Case44_FigureEight) {
  // An open stroke across itself once; deep enough it frees what it runs around.
  const std::vector<Vec2> alpha{{-20, 0}, {10, 0}, {14, 8}, {4, 12}, {-4, -12}};
  for (const double depth : {4.0, 12.0}) {
    SCOPED_TRACE(depth);
    Patient p(2);
    const uint64_t hash = p.a.full_hash();
    const CutResult r = p.incise(alpha, depth);
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(p.cuts, 2);
    EXPECT_EQ(p.a.pieces(), depth > 10 ? 2 : 1);
    EXPECT_EQ(euler(p.a), depth > 10 ? (Chi{0, 2}) : (Chi{2}));
    for (int i = 0; i < p.cuts; ++i) p.a.undo();
    EXPECT_EQ(p.a.full_hash(), hash);
  }
  // A closed eight, from its middle and from its end, through: two plugs that touch, and the rest
  // around both: one hole.
  std::vector<Vec2> eight;
  for (int i = 0; i <= 64; ++i) {
    const double t = 2 * M_PI * i / 64;
    eight.push_back({16 * std::sin(t), 9 * std::sin(2 * t)});
  }
  for (const int turn : {0, 16, 5}) {
    SCOPED_TRACE(turn);
    std::vector<Vec2> from(eight.begin() + turn, eight.end());
    from.insert(from.end(), eight.begin() + 1, eight.begin() + turn + 1);
    for (const double depth : {4.0, 12.0}) {
      Patient p(2);
      const CutResult r = p.incise(from, depth);
      ASSERT_TRUE(r.ok()) << r.reason;
      EXPECT_EQ(p.a.pieces(), depth > 10 ? 3 : 1);
      EXPECT_EQ(euler(p.a), depth > 10 ? (Chi{0, 2, 2}) : (Chi{2}));
    }
  }
}

TEST(BladeCases, StrokesThatNearlyMeetThemselves) {
  // Ends beside the stroke's own middle, short of it or past it: a post is freed all around.
  for (const double gap : {-0.4, -0.1, 0.1, 0.4}) {
    SCOPED_TRACE(gap);
    const std::vector<Vec2> nine{{-20, 0}, {10, 0}, {14, 8}, {4, 12}, {0, gap}};
    Patient p(2);
    const CutResult r = p.incise(nine, 12);
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(p.a.pieces(), 2);
    Patient q(2);
    ASSERT_TRUE(q.incise({nine.rbegin(), nine.rend()}, 12).ok());
    EXPECT_EQ(q.a.pieces(), 2);
  }
  // A loop that ends short of, on, or past its own beginning is closed.
  for (const Vec2& off :
       {Vec2(0, 0), Vec2(0.3, 0.2), Vec2(-0.3, 0.3), Vec2(0, -1.5), Vec2(0.2, -1.5), Vec2(-0.2, -1)}) {
    SCOPED_TRACE(off.transpose());
    const std::vector<Vec2> loop{{10, 0}, {12, 9}, {-3, 12}, {-8, 2}, {-3, -9}, Vec2(10, 0) + off};
    std::vector<Vec2> closing = loop;
    if (off.y() < -0.5)
      closing = {{10, 0}, {12, 9}, {-3, 12}, {-8, 2}, {-2, -9}, {9, -1}, Vec2(10, 0) + Vec2(off.x(), 1)};
    Patient p(2);
    const CutResult r = p.incise(closing, 12);
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(p.a.pieces(), 2);
    EXPECT_EQ(euler(p.a), (Chi{0, 2}));  // case 5: a drilled slab and its core
  }
}

TEST(BladeCases, Case16_SharpBends) {
  for (const double degrees : {5.0, 12.0, 30.0}) {
    SCOPED_TRACE(degrees);
    const double t = degrees * M_PI / 180;
    Patient p(2);
    const CutResult r = p.incise({Vec2(0, 0) - 18 * Vec2(std::cos(t), -std::sin(t)), {0, 0}, {-18, 0}}, 4);
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(euler(p.a), Chi{2});
    Patient q(2);  // as two strokes
    ASSERT_TRUE(q.incise({{-18, 0}, {0, 0}}, 4).ok());
    const CutResult s = q.incise({{0, 0}, Vec2(0, 0) - 18 * Vec2(std::cos(t), -std::sin(t))}, 4);
    ASSERT_TRUE(s.ok()) << s.reason;
    EXPECT_EQ(euler(q.a), Chi{2});
  }
}

TEST(BladeCases, DeepensThroughSharpCorners) {
  // Along both legs and through the corner in one stroke, as a hand does it: neither refused, nor left shallow at the
  // corner when upright. Where a leaning blade meets itself it stays shallower there; the same stroke once more goes on
  // with that (by 9.6 % of the area at most, 2026-11-23), and a third time there is nothing left.
  const std::vector<Vec2> zigzag{{30.2, -14.9}, {23.9, -12}, {-23.9, 15.8}, {28.2, 12.1}, {-13.8, 24}};
  for (const std::vector<Vec2>& path : {std::vector<Vec2>{{-18, 0}, {4, 1}, {-12, 10}}, zigzag})
    for (const double angle : {90.0, 45.0, 65.0, 120.0})
      for (const double off : {0.0, 0.15}) {
        SCOPED_TRACE(testing::Message() << path.size() << " points, " << angle << " degrees, off by " << off);
        Patient p(2), q(2);
        ASSERT_TRUE(p.incise(path, 3, angle).ok());
        const double front = p.front_length();
        std::vector<Vec2> second = path;
        for (size_t i = 0; i < second.size(); ++i) second[i] += Vec2(i % 2 ? off : -off, off);
        const CutResult r = p.incise(second, 7, angle);
        ASSERT_TRUE(r.ok()) << r.reason;
        EXPECT_EQ(p.a.pieces(), 1);
        EXPECT_EQ(euler(p.a), Chi{2});
        if (angle == 90) {  // the foot has moved down, two ends are 4 mm longer
          EXPECT_NEAR(p.front_length(), front + 2 * 4, 1.0);
        }
        EXPECT_EQ(p.incise(second, 3, angle).status, CutResult::nothing_to_cut);
        const double area = p.wall_area();
        const CutResult again = p.incise(second, 7, angle);
        EXPECT_NE(again.status, CutResult::refused);
        if (angle == 90) {
          EXPECT_EQ(again.status, CutResult::nothing_to_cut);
        }
        EXPECT_LE(p.wall_area(), 1.1 * area);
        EXPECT_EQ(p.incise(second, 7, angle).status, CutResult::nothing_to_cut);
        EXPECT_EQ(euler(p.a), Chi{2});
      }
}

TEST(BladeCases, Splines) {
  const std::vector<Vec2> control{{-20, 0}, {-8, 9}, {6, 4}, {12, -9}, {24, -12}};
  const std::vector<Vec2> curve = spline_through(control, 0.5);
  for (const Vec2& c : control)
    EXPECT_TRUE(std::any_of(curve.begin(), curve.end(), [&](const Vec2& p) { return (p - c).norm() < 1e-12; }));
  double longest = 0, turn = 0;
  for (size_t i = 0; i + 1 < curve.size(); ++i) longest = std::max(longest, (curve[i + 1] - curve[i]).norm());
  for (size_t i = 1; i + 1 < curve.size(); ++i)
    turn = std::max(
        turn,
        std::acos(std::min(1.0, (curve[i] - curve[i - 1]).normalized().dot((curve[i + 1] - curve[i]).normalized()))));
  EXPECT_LT(longest, 1.0);
  EXPECT_LT(turn, 0.35);  // smooth: the control polygon turns by up to 1.45
  EXPECT_FALSE(meets_itself(curve, false));
  // Straight runs stay straight, corners stay.
  const std::vector<Vec2> straight = spline_through(std::vector<Vec2>{{0, 0}, {4, 3}, {12, 9}, {20, 15}}, 0.5);
  for (const Vec2& p : straight) EXPECT_NEAR(p.x() * 3 - p.y() * 4, 0, 1e-9);
  const std::vector<Vec2> bent = spline_through(std::vector<Vec2>{{0, 0}, {10, 0}, {10, 10}}, 0.5);
  for (const Vec2& p : bent) EXPECT_TRUE(std::abs(p.y()) < 1e-9 || std::abs(p.x() - 10) < 1e-9);
  // Refined sampling converges: same curve.
  const std::vector<Vec2> fine = spline_through(control, 0.05);
  EXPECT_NEAR(path_length(curve), path_length(fine), 2e-3 * path_length(fine));
  Patient p(2);
  ASSERT_TRUE(p.incise(control, 4, 70, true).ok());
  EXPECT_EQ(euler(p.a), Chi{2});
  const double direct = p.wall_area();
  Patient q(2);
  ASSERT_TRUE(q.incise(curve, 4, 70).ok());
  EXPECT_NEAR(q.wall_area(), direct, 1e-9);
}

}  // namespace test_blade_cases
}  // namespace limberg::test
