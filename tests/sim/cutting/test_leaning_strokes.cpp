// Leaning walls that are deepened while the hand draws: the slit stays a slit. A deeper blade behind a bend that ran
// into the wall before the bend would leave a bridge of tissue across the cut, which the Euler characteristic counts.
#include <cstdlib>

#include "sim/cutting/arrangement/handles.h"
#include "sim/cutting/strokes/blade_parts.h"
#include "sim/cutting/strokes/drawn_stroke.h"
#include "tests/sim/cutting/patient.h"
#include "tests/sim/drawn_pieces.h"

namespace limberg::test {
namespace test_leaning_strokes {

struct Path {
  std::string name;
  std::vector<Vec2> point;
};

std::vector<Path> paths() {
  std::vector<Path> out;
  for (const double turn_deg : {30.0, 60.0, 100.0, 140.0})
    for (const double side : {1.0, -1.0}) {
      const double t = turn_deg * M_PI / 180;
      out.push_back({"corner of " + std::to_string(int(side * turn_deg)),
                     {{-17, -3 * side}, {2, -3 * side}, {2 + 15 * std::cos(t), side * (-3 + 15 * std::sin(t))}}});
    }
  for (const double radius : {5.0, 9.0, 16.0}) {
    Path p{"arc of " + std::to_string(int(radius)) + " mm", {}};
    const double span = std::min(4.2, 28 / radius);
    for (int i = 0; i <= 24; ++i) {
      const double u = span * (i / 24.0 - 0.5);
      p.point.push_back({radius * std::sin(u), radius * (1 - std::cos(u)) - 4});
    }
    out.push_back(p);
  }
  Path s{"S", {}};
  for (int i = 0; i <= 30; ++i) s.point.push_back({i - 15.0, 5 * std::sin(0.35 * (i - 15.0))});
  out.push_back(s);
  return out;
}

/// Empty, or why the stroke was refused.
std::string draw(Patient& p, const std::vector<Vec2>& path, double piece_mm, double depth, double angle) {
  DrawnStroke stroke(depth, angle);
  const auto parts = drawn_pieces(path, piece_mm);
  const BladeContext c = p.context();
  for (size_t i = 0; i < parts.size(); ++i) {
    if (std::string why = stroke.draw(c, parts[i]); !why.empty()) return why;
    const CutResult r =
        stroke.cut(c, i + 1 == parts.size(), [&](const Blade& blade) { return p.a.cut(blade, p.seed++); });
    if (r.status == CutResult::refused) return r.reason;
  }
  return {};
}

/// In pieces of piece_mm, or (0) at once. Empty, or why it was refused.
std::string first_stroke(Patient& p, const std::vector<Vec2>& path, double piece_mm, double depth, double angle) {
  if (piece_mm > 0) return draw(p, path, piece_mm, depth, angle);
  const CutResult r = incise(p.a, p.context(), path, depth, angle, 1);
  return r.ok() ? "" : r.reason;
}

// Four corners to either side, three arcs and an S; blades from 30 to 150 degrees;
// three depths; three lengths of pieces; the wall that is deepened made at once and
// drawn. LIMBERG_LEANING_ALL=1 runs all 1,944 of them, else every ninth is run.
TEST(LeaningStrokes, DeepenedInPiecesLeaveNoBridge) {
  const int step = std::getenv("LIMBERG_LEANING_ALL") ? 1 : 9;
  int number = 0, made = 0, drawn_first = 0, bridges_of_first = 0, refused_first = 0, bridges_of_cone = 0;
  for (const Path& path : paths())
    for (const double angle : {30.0, 45.0, 60.0, 75.0, 105.0, 120.0, 125.0, 135.0, 150.0})
      for (const double depth : {4.0, 5.0, 7.0})
        for (const double piece_mm : {5.0, 1.7, 0.8})
          for (const bool drawn : {false, true}) {
            if (number++ % step) continue;
            SCOPED_TRACE(path.name + ", leaning at " + std::to_string(angle) + ", " + std::to_string(depth) +
                         " mm deep, in pieces of " + std::to_string(piece_mm) +
                         (drawn ? ", the first cut drawn" : ", the first cut at once"));
            Patient p(2);
            drawn_first += drawn;
            if (!drawn) {
              ASSERT_TRUE(incise(p.a, p.context(), path.point, 2.5, angle, 1).ok());
              ASSERT_EQ(euler_characteristic(p.a), 2);
            } else if (draw(p, path.point, piece_mm, 2.5, angle) != "") {
              ++refused_first;
              continue;
            }
            const int64_t chi = euler_characteristic(p.a);
            bridges_of_first += chi != 2;
            const double before = p.wall_area();
            EXPECT_EQ(draw(p, path.point, piece_mm, depth, angle), "");
            // (Pieces that come off raise it: round an arc of 5 mm a blade that leans in by 60 degrees meets itself,
            // and of those 18 deepenings 2 leave a bridge, 2026-11-23.)
            if (path.name == "arc of 5 mm" && angle == 150)
              bridges_of_cone += euler_characteristic(p.a) < chi;
            else
              EXPECT_GE(euler_characteristic(p.a), chi);
            EXPECT_GT(p.wall_area(), 1.05 * before);
            EXPECT_EQ(p.a.check_all(), "");
            ++made;
          }
  EXPECT_GT(made, 0.99 * number / step);
  EXPECT_EQ(refused_first, 0);
  EXPECT_EQ(bridges_of_first, 0);
  EXPECT_LE(bridges_of_cone, 2);
  std::printf("%d deepened; of %d first cuts that were drawn %d refused, %d with a bridge\n", made, drawn_first,
              refused_first, bridges_of_first);
}

// The same paths and angles, three depths, drawn in three lengths of pieces and made at once. LIMBERG_LEANING_ALL=1
// runs all 1,296 of them, else every seventh is run. Before strokes were made in legs (blade_parts.h) 51 of the 972
// that are drawn were refused or left
// a bridge (2026-11-22), and those made at once stood upright over all of their length: see the next test.
TEST(LeaningStrokes, FirstStrokesLeaveNoBridge) {
  const int step = std::getenv("LIMBERG_LEANING_ALL") ? 1 : 7;
  int number = 0, made = 0;
  for (const Path& path : paths())
    for (const double angle : {30.0, 45.0, 60.0, 75.0, 105.0, 120.0, 125.0, 135.0, 150.0})
      for (const double depth : {4.0, 5.0, 7.0})
        for (const double piece_mm : {5.0, 1.7, 0.8, 0.0}) {
          if (number++ % step) continue;
          SCOPED_TRACE(path.name + ", leaning at " + std::to_string(angle) + ", " + std::to_string(depth) +
                       " mm deep, " + (piece_mm > 0 ? "in pieces of " + std::to_string(piece_mm) : "at once"));
          Patient p(2);
          EXPECT_EQ(first_stroke(p, path.point, piece_mm, depth, angle), "");
          EXPECT_EQ(euler_characteristic(p.a), 2);
          EXPECT_EQ(p.a.check_all(), "");
          ++made;
        }
  EXPECT_GT(made, 100);
}

// Leaning into a corner every leg keeps its lean and its depth to its end. The second is
// trimmed where it meets the first, at the bisector of the corner: z mm deep its edge
// has run back by z tan(turn / 2) / tan(angle). Drawn or at once, the area is that.
TEST(LeaningStrokes, LegsKeepTheirLeanUpToTheCorner) {
  for (const double turn_deg : {30.0, 60.0, 100.0, 140.0})
    for (const double side : {1.0, -1.0})
      for (const double angle_deg : {30.0, 45.0, 60.0})
        for (const double depth : {2.5, 7.0})
          for (const double piece_mm : {5.0, 0.8, 0.0}) {
            const double t = turn_deg * M_PI / 180, angle = angle_deg * M_PI / 180,
                         run_back = std::tan(t / 2) / std::tan(angle);
            const double first = 19, second = 15, foot = depth + kWallExtra;
            if (run_back * (depth + 2 * kWallExtra) < 0.3 * kSpacing) continue;  // so little is mitred
            SCOPED_TRACE(testing::Message() << "corner of " << side * turn_deg << ", leaning by " << angle_deg << ", "
                                            << depth << " mm deep, pieces of " << piece_mm);
            const std::vector<Vec2> path{
                {2 - first, -3 * side}, {2, -3 * side}, {2 + second * std::cos(t), side * (-3 + second * std::sin(t))}};
            Patient p(2);
            ASSERT_EQ(first_stroke(p, path, piece_mm, depth, side > 0 ? 180 - angle_deg : angle_deg), "");
            EXPECT_EQ(euler_characteristic(p.a), 2);
            const double deep = std::min(foot, second / run_back);
            const double area = (first + kEndClearance) * foot + second * deep - run_back * deep * deep / 2;
            // Depths vary by 0.04 mm from cut to cut (wall_extra), ends by 0.2.
            EXPECT_NEAR(p.wall_area() * std::sin(angle), area, 0.04 * (first + second) + 0.2 * foot);
          }
}

// A curve into which a blade leans runs together at depth: at once or drawn it is cut in parts that cross one another
// or turn upright there, and what comes of it is one slit of at least the area that an upright blade cuts.
TEST(LeaningStrokes, CurvesThatWouldFoldAreCutInParts) {
  for (const double radius : {6.0, 9.0})
    for (const double side : {1.0, -1.0})
      for (const double depth : {4.0, 7.0})
        for (const double piece_mm : {1.7, 0.0}) {
          SCOPED_TRACE(testing::Message()
                       << "arc of " << side * radius << " mm, " << depth << " mm deep, pieces of " << piece_mm);
          std::vector<Vec2> path;
          for (int i = 0; i <= 24; ++i) {
            const double u = 1.6 * (i / 24.0 - 0.5);
            path.push_back({radius * std::sin(u), side * (radius * (1 - std::cos(u)) - 4)});
          }
          Patient p(2);
          EXPECT_EQ(first_stroke(p, path, piece_mm, depth, side > 0 ? 150 : 30), "");  // leaning inwards
          EXPECT_EQ(euler_characteristic(p.a), 2);
          EXPECT_EQ(p.a.check_all(), "");
          // At least as much as an upright blade of that depth cuts, at most as much as one that leans so to its foot.
          const double upright = 1.6 * radius * depth;
          EXPECT_GT(p.wall_area(), upright);
          EXPECT_LT(p.wall_area(), 2.1 * upright);
        }
}

// What had led to such bridges: of two parts of one straight line the lines' intersection is a quotient of rounding
// errors, and was taken for a place where the path crosses itself, after which its own walls were not kept clear of.
TEST(LeaningStrokes, AStraightLineInPiecesDoesNotCrossItself) {
  for (int i = 0; i < 400; ++i) {
    const double angle = 0.0157 * i, length = 17 + 0.01 * i;
    const Vec2 way(std::cos(angle), std::sin(angle)), from(-17.3 + 0.013 * i, -3.1);
    for (const double piece_mm : {1.7, 0.8, 0.55}) {
      std::vector<Vec2> path;
      for (const auto& part : drawn_pieces({from, from + length * way}, piece_mm))
        path.insert(path.end(), part.begin(), part.end());
      EXPECT_TRUE(self_crossings(path).empty()) << i;
      EXPECT_FALSE(meets_itself(path, false)) << i;
    }
  }
  EXPECT_EQ(self_crossings(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 2}, {2, -2}}).size(), 1u);
  EXPECT_EQ(self_crossings(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 2}, {2, 0}}).size(), 1u);  // touched is crossed
}

}  // namespace test_leaning_strokes
}  // namespace limberg::test
