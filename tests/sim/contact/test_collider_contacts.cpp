// Tissue against what does not move: it stops there, its forces balance, what overlaps at rest does not push, and undo
// brings all of it back.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/contact/collider_contacts.h"
#include "sim/geometry/enclosed_volume.h"
#include "sim/measure/patient.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_collider_contacts {

/// A box whose faces look outwards.
std::shared_ptr<const Collider> box(const Vec3& low, const Vec3& high) {
  auto c = std::make_shared<Collider>();
  for (int k = 0; k < 8; ++k)
    c->mesh.X_mm.push_back({(k & 1 ? high : low).x(), (k & 2 ? high : low).y(), (k & 4 ? high : low).z()});
  for (const auto& [p, q, r, s] :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    c->mesh.tri.push_back({p, q, r}), c->mesh.tri.push_back({p, r, s});
  return c;
}

/// A ball about `centre`, fine enough to be round.
std::shared_ptr<const Collider> ball(const Vec3& centre, double radius) {
  constexpr int kRound = 48, kUp = 24;
  auto c = std::make_shared<Collider>();
  TriMesh& m = c->mesh;
  const auto at = [&](int i, int j) {
    const double a = 2 * M_PI * i / kRound, b = M_PI * j / kUp;
    return Vec3(centre + radius * Vec3(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), -std::cos(b)));
  };
  m.X_mm.push_back(at(0, 0));
  for (int j = 1; j < kUp; ++j)
    for (int i = 0; i < kRound; ++i) m.X_mm.push_back(at(i, j));
  m.X_mm.push_back(at(0, kUp));
  const auto id = [&](int i, int j) { return int32_t(1 + (j - 1) * kRound + i % kRound); };
  const auto top = int32_t(m.X_mm.size() - 1);
  for (int i = 0; i < kRound; ++i) {
    m.tri.push_back({0, id(i + 1, 1), id(i, 1)});
    m.tri.push_back({top, id(i, kUp - 1), id(i + 1, kUp - 1)});
    for (int j = 1; j + 1 < kUp; ++j)
      m.tri.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)}),
          m.tri.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
  }
  return c;
}

WorldSpec block(std::shared_ptr<const Collider> against) {
  WorldSpec spec = test::small_block({.along = 1, .across = 1});
  auto body = std::make_shared<Body>(*spec.body);
  if (against) body->colliders = {std::move(against)};
  spec.body = body;
  spec.contact = ContactChoice::automatic;
  return spec;
}

StepReport settle(World& world, int steps = 60) {
  StepSettings s;
  s.max_iterations = 30, s.tolerance = 1e-6;
  StepReport r;
  for (int i = 0; i < steps; ++i)
    if (r = world.step(s); r.converged) break;
  return r;
}

/// Displacement of the skin's highest place, mm.
double highest_mm(const World& world) {
  Snapshot s;
  world.fill(s);
  double most = -1e9;
  for (const Vec3f& x : s.x_mm) most = std::max(most, double(x.z()));
  return most;
}

const SkinLoad kLift{{0, 0}, {0, 0, 0.6}, 6};

TEST(Colliders, SkinThatIsLiftedStopsAtAPlateAndForcesBalance) {
  InlineWorkers workers;
  constexpr double kGap_mm = 0.5;
  WorldSpec free = block(nullptr), stopped = block(box({-25, -25, kGap_mm}, {25, 25, 12}));
  free.loads = stopped.loads = {kLift};
  World a(free, workers), b(stopped, workers);
  settle(a);
  const StepReport r = settle(b);
  ASSERT_GT(highest_mm(a), 1.5) << "the load lifts it past the plate where there is none";
  EXPECT_TRUE(r.converged);
  // Under a pressure p a place yields by p h / (c E) and a little for the soft beginning of the spring.
  const Vec3 plate_mN = b.skin()->collider_force_mN();
  EXPECT_LT(plate_mN.z(), -50);
  EXPECT_LT(plate_mN.head<2>().norm(), 1e-3 * plate_mN.norm()) << "no friction on level ground";
  EXPECT_GT(highest_mm(b), kGap_mm - 0.02);
  EXPECT_LT(highest_mm(b), kGap_mm + 0.2);
  Snapshot s;
  b.fill(s);
  const Vec3 sum = b.skin()->solver().load_force_mN() + plate_mN - b.skin()->solver().support_force_mN();
  EXPECT_LT(sum.norm(), 1e-3 * b.skin()->solver().load_force_mN().norm());
  const Metrics m = measure_world(b, {});
  EXPECT_LT(m.balance.relative, 1e-3);
}

// Skin is lifted against the plate by a hook and then drawn along it, to and fro: without friction the plate does not
// hold it, with some by just that share of the push, against the way; and everything still balances.
TEST(Colliders, FrictionHoldsBackWhatIsDrawnAlongAPlate) {
  for (const double friction : {0.0, 0.2}) {
    SCOPED_TRACE(friction);
    InlineWorkers workers;
    WorldSpec spec = block(box({-25, -25, 0.5}, {25, 25, 12}));
    spec.contact_friction = friction, spec.hook_k_N_per_mm = 5;
    World world(spec, workers);
    ASSERT_TRUE(world.apply(SetHook{1, {0, 0}}).done);
    Vec3 at(0, 0, 0);
    const auto drawn_to = [&](const Vec3& to, int steps) {
      const Vec3 from = at;
      for (int k = 1; k <= steps; ++k) {
        at = from + double(k) / steps * (to - from);
        EXPECT_TRUE(world.apply(MoveHook{1, at, 0}).done);
        StepSettings s;
        s.max_iterations = 200, s.tolerance = 1e-6;
        world.step(s);
      }
      const Vec3 plate_mN = world.skin()->collider_force_mN();
      EXPECT_LT(measure_world(world, {}).balance.relative, 5e-3);
      EXPECT_LT(plate_mN.z(), -50);
      return plate_mN;
    };
    drawn_to({0, 0, 0.9}, 5);
    const Vec3 there = drawn_to({2.5, 0, 0.9}, 25), back = drawn_to({0, 0, 0.9}, 25);
    if (friction == 0) {
      EXPECT_LT(there.head<2>().norm(), 1e-3 * there.norm());
      EXPECT_LT(back.head<2>().norm(), 1e-3 * back.norm());
    } else {  // a push is known to 2 %; at the rim of what presses some hold still
      EXPECT_NEAR(there.x() / there.z(), friction, 0.15 * friction);
      EXPECT_NEAR(back.x() / back.z(), -friction, 0.15 * friction);
    }
  }
}

TEST(Colliders, WhatOverlapsAtRestDoesNotPush) {
  InlineWorkers workers;
  World world(block(box({-25, -25, -0.3}, {25, 25, 12})), workers);
  settle(world);
  EXPECT_EQ(world.skin()->collider_force_mN(), Vec3::Zero());
  EXPECT_LT(highest_mm(world), 1e-4);
}

// A ball in the way of skin that is lifted: no place of the skin lies in it by more than the springs yield, and it
// pushes along its own normals, so that lifting beside it pushes the skin aside.
TEST(Colliders, SkinGoesRoundABall) {
  InlineWorkers workers;
  const Vec3 centre(3, 0, 6.2);
  constexpr double kRadius_mm = 6;
  WorldSpec spec = block(ball(centre, kRadius_mm));
  spec.cell_mm = 3;  // a small ball is met by few cells
  spec.loads = {{{0, 0}, {0, 0, 0.3}, 6}};
  World world(spec, workers);
  EXPECT_TRUE(settle(world).converged);
  const Vec3 force_mN = world.skin()->collider_force_mN();
  EXPECT_LT(force_mN.z(), -20);
  EXPECT_LT(force_mN.x(), -0.01 * std::abs(force_mN.z())) << "the load lies at x < 3: it is pushed towards -x";
  Snapshot s;
  world.fill(s);
  double deepest = 0;
  for (const Vec3f& x : s.x_mm) deepest = std::max(deepest, kRadius_mm - (x.cast<double>() - centre).norm());
  EXPECT_LT(deepest, 0.25);
}

// A place is not asked for before it can have come within reach: what it then presses on is what somebody finds who
// looks everywhere anew.
TEST(Colliders, WhoWaitsForAPlaceMissesNone) {
  InlineWorkers workers;
  const World world(block(ball({3, 0, 8.5}, 6)), workers);
  const SoftTissue& skin = *world.skin();
  const auto surface = skin.topology();
  const FemModel& model = skin.solver().model();
  const auto fresh = [&] { return ColliderContacts(surface->body, surface->view, surface->embedding.flat(), model); };
  ColliderContacts waits = fresh();
  std::vector<Vec3f> u(model.X_mm.size(), Vec3f::Zero());
  size_t most = 0;
  for (int step = 0; step < 60; ++step) {
    for (size_t i = 0; i < u.size(); ++i) {  // it bulges towards the ball, here and there by turns, and swings
      const Vec3 X = model.X_mm[i];
      const double up = 0.07 * step * std::exp(-X.head<2>().squaredNorm() / 200) + 0.4 * std::sin(0.9 * step + X.x());
      u[i] = Vec3(0.3 * std::sin(0.5 * step), 0.3 * std::cos(0.7 * step + X.y()), up).cast<float>();
    }
    waits.follow(u, workers);
    ColliderContacts anew = fresh();
    anew.follow(u, workers);
    std::set<std::array<int32_t, 8>> held;
    for (const Contact& c : waits.contacts()) held.insert(c.a.node);
    for (const Contact& c : anew.contacts()) EXPECT_TRUE(held.contains(c.a.node)) << "step " << step;
    most = std::max(most, anew.contacts().size());
  }
  EXPECT_GT(most, 10u);
}

TEST(Colliders, UndoBringsBackWhatPressed) {
  InlineWorkers workers;
  WorldSpec spec = block(ball({3, 0, 6.1}, 6));
  spec.loads = {kLift};
  World world(spec, workers);
  settle(world);
  const uint64_t before = world.skin()->full_hash();
  const Vec3 force_mN = world.skin()->collider_force_mN();
  ASSERT_TRUE(world.apply(Incise{{{-12, 4}, {12, 5}}, 4}).done);
  settle(world, 10);
  EXPECT_NE(world.skin()->full_hash(), before);
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.skin()->full_hash(), before);
  StepSettings one;
  one.max_iterations = 1;
  world.step(one);
  EXPECT_LT((world.skin()->collider_force_mN() - force_mN).norm(), 1e-2 * force_mN.norm());
}

TEST(Colliders, ColoursOfVerticesAreReadWhereAllHaveThem) {
  const auto colours = [](const char* first, const char* second) {
    const std::string text = std::string("v 0 0 0") + first + "\nv 30 0 0" + second +
                             "\nv 0 20 0 0 0 1\nv 0 0 10 1 1 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    return parse_collider(text, {"wedge.obj"})->rgb;
  };
  const std::vector<Vec3f> all = colours(" 1 0 0", " 0 .5 0");
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[1], Vec3f(0, 0.5f, 0));
  EXPECT_TRUE(colours("", " 0 .5 0").empty()) << "one has none";
  EXPECT_TRUE(colours(" 1 0 0", "").empty());
  EXPECT_TRUE(colours(" 255 0 0", " 0 .5 0").empty()) << "not from 0 to 1";
  EXPECT_TRUE(colours(" 1", " 0 .5 0").empty()) << "a weight";
  EXPECT_TRUE(colours(" 1 0 nan", " 0 .5 0").empty());
}

TEST(Colliders, OneThatIsInsideOutIsTurned) {
  const std::string corners = "v 0 0 0\nv 3 0 0\nv 0 2 0\nv 0 0 1\n";
  ColliderSpec spec;
  const auto out = parse_collider(corners + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", spec);
  const auto in = parse_collider(corners + "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n", spec);
  EXPECT_NEAR(enclosed_volume(out->mesh.X_mm, out->mesh.tri), 1, 1e-12);
  EXPECT_NEAR(enclosed_volume(in->mesh.X_mm, in->mesh.tri), 1, 1e-12);
  spec.closed = false;  // may look either way
  EXPECT_NEAR(
      enclosed_volume(in->mesh.X_mm, parse_collider(corners + "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n", spec)->mesh.tri),
      -1, 1e-12);
}

TEST(Colliders, OpenFlatOrEndlessSurfacesAreRefusedWithTheirLine) {
  const auto why = [](const std::string& text, double scale = 1) -> std::string {
    ColliderSpec spec;
    spec.path = "c.obj", spec.scale_to_mm = scale;
    try {
      parse_collider(text, spec);
      return "";
    } catch (const InputError& e) {
      return e.what();
    }
  };
  const std::string corners = "v 0 0 0\nv 3 0 0\nv 0 2 0\nv 0 0 1\n", three = "f 1 3 2\nf 1 2 4\nf 2 3 4\n";
  EXPECT_EQ(why(corners + three + "f 3 1 4\n"), "");
  EXPECT_EQ(why(corners + three + "f 3 1 4\nf 1 1 2\n").substr(0, 8), "c.obj:9:");
  EXPECT_NE(why(corners + three).find("open at an edge"), std::string::npos);
  EXPECT_NE(why(corners + three + "f 1 3 4\n").find("run the same way"), std::string::npos);
  EXPECT_NE(why("v 0 0 0\nv 3 0 0\nv 0 2 0\nf 1 2 3\nf 3 2 1\n").find("around some volume"), std::string::npos);
  EXPECT_NE(why(corners + three + "f 3 1 4\n", 1000).find("at most 1000"), std::string::npos);
  EXPECT_NE(why(corners).find("no faces"), std::string::npos);
}

}  // namespace test_collider_contacts
}  // namespace limberg
