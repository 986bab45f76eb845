// What a finder makes of motions that are given, without a solver.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/contact/contact_finder.h"
#include "sim/world.h"
#include "tests/sim/contact/plain_block.h"

namespace limberg {
namespace {

// The roof of a pocket is drawn over its floor, now pressed deeply, now lightly. Its places meet new tissue all the time:
// that their pairs turn is no answer that jumps to and fro in one spot, and none may tire. (Here pairs are found anew since
// their weights have changed, not since they are stale: what they slid counts both times.)
TEST(ContactFinder, APlaceThatSlidesOnDoesNotTire) {
  InlineWorkers workers;
  World world(test::plain_block(60), workers);
  ASSERT_TRUE(world.apply(Incise{{{-16, 0}, {16, 0}}, 5, 90}).done);
  std::vector<ChartPoint> outline;
  for (int k = 0; k < 24; ++k) outline.push_back({18 * std::cos(k * M_PI / 12), 18 * std::sin(k * M_PI / 12)});
  ASSERT_TRUE(world.apply(Undermine{outline, 5}).done);
  Snapshot shown;
  world.fill(shown);
  const FemModel& model = world.solver().model();
  const auto surface = contact_surface({shown.topology, &shown.topology->view}, shown.topology->embedding, world.lattice(), model);
  ASSERT_TRUE(surface);
  ContactFinder finder(surface, model);

  // The roof: nodes of copies that carry a downward wall, and what lies above them.
  std::vector<uint8_t> roof(model.X_mm.size(), 0);
  for (size_t i = 0; i < roof.size(); ++i) roof[i] = model.X_mm[i].z() > -2;
  const auto downward = [&](const ContactPlace& p) {
    const Tri& t = surface->tri[size_t(p.triangle)];
    const Vec3 &A = surface->X_mm[size_t(t[0])], &B = surface->X_mm[size_t(t[1])], &C = surface->X_mm[size_t(t[2])];
    return (B - A).cross(C - A).normalized().z() < -0.9;
  };
  for (const ContactPlace& p : surface->place)
    if (downward(p))
      for (int32_t n : p.embedded.node) roof[size_t(n)] = 1;

  std::vector<Vec3f> u(roof.size(), Vec3f::Zero());
  for (int step = 1; step <= 60; ++step) {
    const double slid_mm = 0.1 * step, deep_mm = step % 2 == 0 ? 0.3 : 1.3;  // their weights are far apart
    for (size_t i = 0; i < u.size(); ++i) {
      if (!roof[i]) continue;
      const double r = std::hypot(model.X_mm[i].x(), model.X_mm[i].y());
      u[i] = Vec3(slid_mm * std::clamp((18 - r) / 6, 0.0, 1.0), 0, -deep_mm).cast<float>();
    }
    finder.follow(u, workers);
  }
  size_t pressing = 0;
  int32_t turns = 0;
  const ContactMemory memory = finder.memory();
  const auto inner = [&](int32_t i) {
    const ContactPlace& p = surface->place[size_t(i)];
    return downward(p) && std::hypot(p.X_mm.x(), p.X_mm.y()) < 8;
  };
  for (const HeldContact& h : memory.pairs) pressing += inner(h.place) && h.weight > 0.5;
  for (const ContactMemory::Spot& s : memory.spots)
    if (inner(s.place)) turns = std::max(turns, s.turns);
  EXPECT_GT(pressing, 20u);
  EXPECT_LE(turns, 20);  // after 1 mm, ten of these steps, a place is fresh; a pair that stood meanwhile counts its way late
}

}  // namespace
}  // namespace limberg
