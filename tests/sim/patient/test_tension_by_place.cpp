// Skin whose lines of tension run differently in different places: a slit opens where it lies across them.
#include <gtest/gtest.h>

#include "sim/body/tension_lines.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_tension_by_place {

/// A block as a closed surface, whose lines run as `along` says.
template <class Along>
WorldSpec block(Along&& along) {
  WorldSpec spec = test::small_block({.along = 1.15, .across = 1.0});
  auto body = std::make_shared<Body>(*spec.body);
  body->is_box = false;
  along(*body);
  spec.body = body;
  return spec;
}

/// Two slits of 20 mm along y, one behind the other, at rest.
Snapshot slit_twice(const WorldSpec& spec) {
  InlineWorkers workers;
  World world(spec, workers);
  for (const double y : {-14.0, 14.0}) {
    const Outcome o = world.apply(Incise{{{1, y - 10}, {1, y + 10}}, 4, 90});
    EXPECT_TRUE(o.done) << o.reason;
  }
  StepSettings s;
  s.max_iterations = 400, s.tolerance = 1e-5;
  for (int i = 0; i < 20; ++i)
    if (world.step(s).converged) break;
  Snapshot out;
  world.fill(out);
  return out;
}

/// How wide the slit about y gapes in its middle, on the skin: the mean of its banks' moves apart.
double gape_mm(const Snapshot& s, double y) {
  const SurfaceView& v = s.topology->view;
  double sum[2] = {0, 0};
  int n[2] = {0, 0};
  for (size_t t = 0; t < v.tri.size(); ++t) {
    if (v.kind[t] != FaceKind::wall) continue;
    const Vec3 a = v.X_mm[size_t(v.tri[t][0])], b = v.X_mm[size_t(v.tri[t][1])], c = v.X_mm[size_t(v.tri[t][2])];
    const bool right = (b - a).cross(c - a).x() < 0;  // the wall of the bank at larger x faces it
    for (const int32_t i : v.tri[t]) {
      const Vec3 X = v.X_mm[size_t(i)];
      if (std::abs(X.x() - 1) > 1 || std::abs(X.y() - y) > 4 || X.z() < -1.5) continue;
      sum[right] += double(s.x_mm[size_t(i)].x()) - X.x(), ++n[right];
    }
  }
  EXPECT_GT(n[0], 3);
  EXPECT_GT(n[1], 3);
  return sum[1] / n[1] - sum[0] / n[0];
}

// One half of the skin is drawn along x, the other along y, and both slits lie along y. (Side by side they would not
// do: what draws harder would draw the other half along.)
TEST(TensionByPlace, ASlitOpensWhereItLiesAcrossTheLines) {
  const Snapshot s = slit_twice(block([](Body& b) {
    for (const Vec3& X : b.surface.X_mm) b.tension.push_back(X.y() < 0 ? Vec3f::UnitX() : Vec3f::UnitY());
  }));
  const double across = gape_mm(s, -14), along = gape_mm(s, 14);
  EXPECT_GT(across, 1);
  EXPECT_LT(along, 0.4 * across);
}

TEST(TensionByPlace, OneWayEverywhereIsTensionDirection) {
  const Vec3 d(0.6, 0.8, 0);
  const Snapshot by_place = slit_twice(block([&](Body& b) {
    TensionSpec t;
    t.places = {{{-20, 0, 0}, d}, {{20, 5, 0}, -d}};
    b.tension = tension_lines_of(t, b);
  }));
  const Snapshot by_direction = slit_twice(block([&](Body& b) { b.tension_direction = d; }));
  ASSERT_EQ(by_place.x_mm.size(), by_direction.x_mm.size());
  double worst = 0, most = 0;
  for (size_t i = 0; i < by_place.x_mm.size(); ++i) {
    worst = std::max(worst, double((by_place.x_mm[i] - by_direction.x_mm[i]).norm()));
    most = std::max(most, (by_direction.x_mm[i].cast<double>() - by_direction.topology->view.X_mm[i]).norm());
  }
  EXPECT_GT(most, 0.5);
  EXPECT_LT(worst, 1e-3 * most);
}

}  // namespace test_tension_by_place
}  // namespace limberg
