// A hand that turns back on its own way while it cuts: a busy machine hands over few of its points, and what lies
// between them is a straight line along what was just cut.
#include <random>
#include <stdexcept>

#include "tests/sim/cutting/patient.h"

namespace limberg::test {
namespace test_turned_back {

/// Point by point, as a hand draws. How many blades it took; a stroke that asks for ever is stopped.
int draw(Patient& p, const std::vector<Vec2>& path, double depth_mm, double angle_deg) {
  DrawnStroke stroke(depth_mm, angle_deg);
  const BladeContext c = p.context();
  int blades = 0;
  const auto cut = [&](const Blade& blade) {
    if (++blades > 300) throw std::runtime_error("the stroke comes to no end");
    return p.a.cut(blade, p.seed++);
  };
  for (size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(stroke.draw(c, std::span(path).subspan(i, 1)), "");
    stroke.cut(c, i + 1 == path.size(), cut);
  }
  EXPECT_EQ(p.a.check_all(), "");
  return blades;
}

// The path of a session on a busy machine that stood still beside a defect: the piece that led back to the wall behind
// it met nothing to cut, and the next one was the same.
TEST(TurnedBack, OnWhatWasJustCut) {
  const std::vector<Vec2> path{{0.0529, -0.0116},  {3.5514, -2.1699},  {7.6287, -4.4325},   {10.1982, -5.9551},
                               {12.8746, -7.4722}, {16.6884, -9.7067}, {13.9001, -11.8255}, {9.5721, -14.0897},
                               {7.4773, -15.6055}, {3.5715, -18.3421}, {6.4571, -16.3291},  {5.4141, -16.9036}};
  for (size_t n = path.size() - 3; n <= path.size(); ++n) {
    Patient p;
    EXPECT_LT(draw(p, {path.begin(), path.begin() + long(n)}, 4, 90), 60) << n << " points";
  }
}

TEST(TurnedBack, EndsWhereverTheHandTurns) {
  std::mt19937_64 random(24);
  const auto share = [&] { return double(random() >> 11) * 0x1p-53; };
  for (int seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    std::vector<Vec2> path{{-15, 0}};
    double at = -15, way = 1;
    const double aside = seed % 3 * 0.3;  // mm: on its own way, within a snap of it, beside it
    for (int i = 0; i < 8; ++i) {
      at = std::clamp(at + way * (1 + 9 * share()), -20.0, 20.0);
      path.push_back({at, aside * (2 * share() - 1)});
      if (share() < 0.4) way = -way;
    }
    Patient p;
    try {
      draw(p, path, 4, seed % 2 ? 90 : 60);
    } catch (const std::runtime_error& e) {
      FAIL() << e.what();
    }
  }
}

}  // namespace test_turned_back
}  // namespace limberg::test
