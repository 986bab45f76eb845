// The profile snap: of a stroke along earlier cuts only what they
// have left of its profile (place along the line, depth) is cut.
// What is cut in the end is the union of all profiles, once: no
// second wall beside the first, no sliver between, no bridge.
#include <random>

#include "sim/cutting/arrangement/handles.h"
#include "tests/sim/cutting/patient.h"

namespace limberg::test {
namespace test_profile_snap {

struct Stroke {
  double from = 0, to = 0, depth = 0;  // mm along the line, mm
};

/// A line on the skin: straight, or an arc of 60 mm radius.
Vec2 place(bool curved, double s) {
  return curved ? Vec2(60 * std::sin(s / 60), 60 * (1 - std::cos(s / 60)) - 3.3) : Vec2(s, 0.37);
}

std::vector<Vec2> path_of(bool curved, const Stroke& k, double aside, bool backwards) {
  std::vector<Vec2> out;
  const int n = curved ? int(std::ceil((k.to - k.from) / 3)) : 1;
  for (int i = 0; i <= n; ++i) {
    const double s = k.from + (k.to - k.from) * i / n;
    const Vec2 way = (place(curved, s + 0.01) - place(curved, s - 0.01)).normalized();
    out.push_back(place(curved, s) + aside * Vec2(-way.y(), way.x()));
  }
  if (backwards) std::reverse(out.begin(), out.end());
  return out;
}

/// Area of the union of the profiles.
double union_mm2(const std::vector<Stroke>& strokes) {
  double sum = 0;
  constexpr double kStep = 0.01;
  for (double s = -45; s < 45; s += kStep) {
    double depth = 0;
    for (const Stroke& k : strokes)
      if (s >= k.from && s <= k.to) depth = std::max(depth, k.depth + kWallExtra);
    sum += depth * kStep;
  }
  return sum;
}

/// Walls of one operation that lie beside those of another,
/// nearer than 0.5 mm and parallel: area of their middles' faces.
double doubled_mm2(const Patient& p) {
  struct Wall {
    Vec3 middle, normal;
    int32_t op;
    double area;
  };
  std::vector<Wall> walls;
  for (int32_t f : p.live_walls()) {
    const Face& t = p.a.faces()[size_t(f)];
    if (t.mat != 3) continue;
    const Vec3 a = p.a.point_mm(t.v[0]), b = p.a.point_mm(t.v[1]), c = p.a.point_mm(t.v[2]), n = (b - a).cross(c - a);
    walls.push_back({(a + b + c) / 3, n.normalized(), p.a.orig_tris()[size_t(t.orig)].op, n.norm() / 2});
  }
  double sum = 0;
  for (const Wall& w : walls)
    for (const Wall& o : walls) {
      const Vec3 d = o.middle - w.middle;
      if (o.op == w.op || std::abs(w.normal.dot(o.normal)) < 0.9) continue;
      // Beside it, not beyond its border: the other's middle lies off this plane by little, and on it by little, too.
      if (std::abs(d.dot(w.normal)) > 1e-3 && std::abs(d.dot(w.normal)) < 0.5 &&
          (d - d.dot(w.normal) * w.normal).norm() < 0.4) {
        sum += w.area;
        break;
      }
    }
  return sum;
}

void expect_union(Patient& p, const std::vector<Stroke>& strokes) {
  // A wall is deepened between its columns, 1.5 mm apart: at each end
  // of a stroke up to half of that is more or less, over the depth.
  double slack = 1;
  for (const Stroke& k : strokes) slack += 2 * kSpacing / 2 * k.depth + 0.08 * (k.to - k.from);
  EXPECT_NEAR(p.wall_area(), union_mm2(strokes), slack);
  EXPECT_EQ(p.a.pieces(), 1);
  EXPECT_EQ(euler_characteristic(p.a), 2);
  EXPECT_LT(doubled_mm2(p), 1.5);
}

TEST(ProfileSnap, LongerAndDeeperThanWhatIsThere) {
  for (const bool curved : {false, true})
    for (const double aside : {0.0, 0.2, -0.2})
      for (const bool backwards : {false, true}) {
        SCOPED_TRACE(testing::Message() << (curved ? "curved" : "straight") << ", aside " << aside
                                        << (backwards ? ", backwards" : ""));
        Patient p;
        std::vector<Stroke> strokes{{-20, 6, 3}};
        ASSERT_TRUE(p.incise(path_of(curved, strokes[0], 0, false), 3).ok());
        const double first = p.wall_area();
        strokes.push_back({-8, 21, 5.5});  // deeper where the first is, as deep as asked where it is not
        ASSERT_TRUE(p.incise(path_of(curved, strokes[1], aside, backwards), 5.5).ok());
        expect_union(p, strokes);
        EXPECT_GT(p.wall_area(), first + 90);
        // A shallower one over all of it: nothing is left of its profile.
        const uint64_t hash = p.a.full_hash();
        const CutResult r = p.incise(path_of(curved, {-18, 18, 2.5}, aside, backwards), 2.5);
        EXPECT_EQ(r.status, CutResult::nothing_to_cut) << r.reason;
        EXPECT_EQ(p.a.full_hash(), hash);
        // A shallower one that reaches beyond: its end alone.
        strokes.push_back({-34, -10, 2});
        const double before = p.wall_area();
        ASSERT_TRUE(p.incise(path_of(curved, strokes.back(), aside, backwards), 2).ok());
        expect_union(p, strokes);
        EXPECT_NEAR(p.wall_area() - before, 14 * (2 + kWallExtra), 4);
      }
}

// Any number of strokes along one line, in any order: what is cut is what the deepest of them asks for everywhere.
TEST(ProfileSnap, ManyStrokesAlongOneLineAreTheirUnion) {
  std::mt19937 random(20261122);
  const auto below = [&](unsigned n) { return int(random() % n); };
  int deepened = 0;
  for (int scene = 0; scene < 8; ++scene) {
    SCOPED_TRACE(testing::Message() << "scene " << scene);
    const bool curved = scene % 2 == 1;
    Patient p;
    std::vector<Stroke> strokes;
    for (int i = 0; i < 5; ++i) {
      // Ends are 7 mm from each other or the same: shorter ways along a wall are taken for chance (kLeastAlong).
      const int from = below(5), to = from + 1 + below(unsigned(6 - from));
      const Stroke k{-28 + 9.0 * from, -28 + 9.0 * to, 2.0 + below(5)};
      const double before = p.wall_area();
      const CutResult r = p.incise(path_of(curved, k, 0.1 * (below(5) - 2), below(2) == 1), k.depth);
      ASSERT_NE(r.status, CutResult::refused) << r.reason;
      strokes.push_back(k);
      deepened += r.ok() && before > 0;
    }
    expect_union(p, strokes);
  }
  EXPECT_GT(deepened, 12);
}

// A whole blade on walls of two operations is nothing; one that reaches 0.3 mm below either of them is not dropped.
TEST(ProfileSnap, ABladeOnTwoWallsTogetherIsCutAlready) {
  Patient p;
  ASSERT_TRUE(p.incise({{-20, 0}, {0, 0}}, 4).ok());
  ASSERT_TRUE(p.incise({{0, 0}, {20, 0}}, 4).ok());
  const auto blade = [&](double bottom) { return strip({{-15.3, 0.01}, {14.2, 0.01}}, 1.0 - 0.06, bottom); };
  const uint64_t hash = p.a.full_hash();
  EXPECT_EQ(p.a.cut(blade(-3.5), 3).status, CutResult::nothing_to_cut);
  EXPECT_EQ(p.a.full_hash(), hash);
  const CutResult deeper = p.a.cut(blade(-4.5), 3);
  EXPECT_TRUE(deeper.ok()) << deeper.reason;
  EXPECT_EQ(p.a.check_all(), "");
}

}  // namespace test_profile_snap
}  // namespace limberg::test
