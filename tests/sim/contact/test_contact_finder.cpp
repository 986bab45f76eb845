// What a finder makes of motions that are given, without a solver.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "sim/contact/contact_finder.h"
#include "sim/fem/forces/contact_forces.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/contact/plain_block.h"

namespace limberg {
namespace test_contact_finder {

/// A pocket under a slit in a plain block: nothing of it has moved yet.
class APocket : public ::testing::Test {
 protected:
  void SetUp() override {
    world = std::make_unique<World>(test::plain_block(60), workers);
    ASSERT_TRUE(world->apply(Incise{{{-16, 0}, {16, 0}}, 5, 90}).done);
    std::vector<ChartPoint> outline;
    for (int k = 0; k < 24; ++k) outline.push_back({18 * std::cos(k * M_PI / 12), 18 * std::sin(k * M_PI / 12)});
    ASSERT_TRUE(world->apply(Undermine{outline, 5}).done);
    Snapshot shown;
    world->fill(shown);
    surface = contact_surface({shown.topology, &shown.topology->view}, shown.topology->embedding,
                              world->skin()->lattice(), model());
    ASSERT_TRUE(surface);
    // The roof: nodes of copies that carry a downward wall, and what lies above them.
    roof.assign(model().X_mm.size(), 0);
    for (size_t i = 0; i < roof.size(); ++i) roof[i] = model().X_mm[i].z() > -2;
    for (const ContactPlace& p : surface->place)
      if (downward(p))
        for (int32_t n : p.embedded.node) roof[size_t(n)] = 1;
  }
  const FemModel& model() const { return world->skin()->solver().model(); }
  bool downward(const ContactPlace& p) const {
    const Tri& t = surface->tri[size_t(p.triangle)];
    const Vec3 &A = surface->X_mm[size_t(t[0])], &B = surface->X_mm[size_t(t[1])], &C = surface->X_mm[size_t(t[2])];
    return (B - A).cross(C - A).normalized().z() < -0.9;
  }
  bool inner(int32_t i) const {
    const ContactPlace& p = surface->place[size_t(i)];
    return downward(p) && std::hypot(p.X_mm.x(), p.X_mm.y()) < 8;
  }
  /// The middle of the roof is moved so, its rim not at all.
  std::vector<Vec3f> moved(const Vec3& by_mm) const {
    std::vector<Vec3f> u(roof.size(), Vec3f::Zero());
    for (size_t i = 0; i < u.size(); ++i) {
      if (!roof[i]) continue;
      const double share = std::clamp((18 - std::hypot(model().X_mm[i].x(), model().X_mm[i].y())) / 6, 0.0, 1.0);
      u[i] = Vec3(by_mm.x() * share, by_mm.y() * share, by_mm.z()).cast<float>();
    }
    return u;
  }
  /// Pairs of the roof's middle that press.
  size_t pressing(const ContactFinder& finder) const {
    size_t n = 0;
    for (const HeldContact& h : finder.memory().pairs) n += inner(h.place) && h.depth_tested && h.weight > 0.5;
    return n;
  }

  InlineWorkers workers;
  std::unique_ptr<World> world;
  std::shared_ptr<const ContactSurface> surface;
  std::vector<uint8_t> roof;
};

// The roof of a pocket is drawn over its floor, now pressed deeply, now lightly. Its places meet new tissue all the
// time: their pairs are projected anew, but not in one neighbourhood, and none may be damped. (Here pairs are found
// anew since their weights have changed, not since they are stale: what they slid counts both times.)
TEST_F(APocket, APlaceThatSlidesOnIsNotDamped) {
  ContactFinder finder(surface, model());
  for (int step = 1; step <= 60; ++step) {
    const double slid_mm = 0.1 * step, deep_mm = step % 2 == 0 ? 0.3 : 1.3;  // their weights are far apart
    finder.follow(moved({slid_mm, 0, -deep_mm}), workers);
  }
  int32_t projections = 0;
  for (const ContactMemory::Damping& d : finder.memory().damping)
    if (inner(d.place)) projections = std::max(projections, d.projections);
  EXPECT_GT(pressing(finder), 20u);
  // After 1 mm, ten of these steps, a place is fresh; a pair that stood meanwhile counts its way late.
  EXPECT_LE(projections, 20);
}

// The roof is thrown aside and comes down slowly over other tissue than it was cut from. What is near it was not near
// before it was thrown; each single step brings it nearer by less than would make anybody look afresh.
TEST_F(APocket, WhatIsThrownAndThenSinksMeetsWhatIsThere) {
  ContactFinder finder(surface, model());
  finder.follow(moved({0, 0, 0}), workers);
  for (int i = 1; i <= 4; ++i) finder.follow(moved({1.5 * i, 0, 0.4 * i}), workers);
  for (double up_mm = 1.5; up_mm > -0.35; up_mm -= 0.1) finder.follow(moved({6, 0, up_mm}), workers);
  ContactFinder fresh(surface, model());
  fresh.follow(moved({6, 0, -0.3}), workers);
  ASSERT_GT(pressing(fresh), 20u);
  EXPECT_GE(pressing(finder),
            pressing(fresh) * 9 / 10);  // those at the rim of what counts may stand as they were found
}

// The roof moves by a third of a millimetre, less and less each time: its places are looked at anew as it slows down,
// not only after the next tenth; and no more once it stands, however often it is asked.
TEST_F(APocket, WhatComesToRestIsLookedAtAgain) {
  ContactFinder finder(surface, model());
  finder.follow(moved({0, 0, 0}), workers);
  finder.follow(moved({0, 0, -0.1}), workers);
  double at_mm = 0.1, step_mm = 0.1;
  uint64_t before = finder.counts().queries;
  for (; step_mm > 1e-3; step_mm *= 0.6) finder.follow(moved({0, 0, -(at_mm += step_mm)}), workers);
  ASSERT_LT(at_mm, 0.36);
  EXPECT_GT(finder.counts().queries, before + surface->place.size() / 4);
  before = finder.counts().queries;
  for (int k = 0; k < 20; ++k) finder.follow(moved({0, 0, -at_mm + 1e-4 * (k % 2)}), workers);
  EXPECT_EQ(finder.counts().queries, before);
}

// The roof is pressed upon its floor and drawn over it by 3 mm, a tenth of a millimetre a step, so that every pair
// finds another foot many times: friction holds it back all the while, by its share of the push; and turns round when
// it does.
TEST_F(APocket, WhatIsDrawnOverItsBedIsHeldBack) {
  constexpr double kMu = 0.2;
  ContactFinder finder(surface, model(), kMu);
  const auto held_back = [&](const std::vector<Vec3f>& u) {  // along x, and what it may be at most; mN
    finder.follow(u, workers, true);
    fem::ContactForces forces(model(), finder.contacts());
    NodeArray at(u.size());
    for (size_t i = 0; i < u.size(); ++i) at[i] = {u[i][0], u[i][1], u[i][2], 0};
    double along = 0, most = 0;
    size_t c = 0;
    for (const HeldContact& h : finder.memory().pairs) {
      if (!(h.weight > 1e-4)) continue;  // the others are no contacts
      const double push = forces.force_mN(c, at);
      if (inner(h.place) && push > 0) along += forces.friction_mN(c, at).x(), most += kMu * push;
      ++c;
    }
    EXPECT_EQ(c, finder.contacts().size());
    return std::pair(along, most);
  };
  held_back(moved({0, 0, -0.1}));
  const auto [before, could] = held_back(moved({0, 0, -0.2}));
  ASSERT_GT(could, 20);
  EXPECT_LT(std::abs(before), 0.02 * could) << "it was pressed down, not aside";
  for (int step = 1; step <= 30; ++step) {
    const auto [now, most] = held_back(moved({0.1 * step, 0, -0.2}));
    EXPECT_GT(most, 0.7 * could);
    if (step < 3) continue;
    EXPECT_LT(now, -0.93 * most) << "step " << step;  // normals are some degrees off z
    EXPECT_GT(now, -1.05 * most) << "step " << step;  // a push is known to 2 %, and not beyond the last step
  }
  EXPECT_GT(finder.counts().reprojected, 100u);
  for (int step = 1; step <= 5; ++step) {
    const auto [now, most] = held_back(moved({3 - 0.1 * step, 0, -0.2}));
    if (step < 3) continue;
    EXPECT_GT(now, 0.93 * most) << "back, step " << step;
  }
}

}  // namespace test_contact_finder
}  // namespace limberg
