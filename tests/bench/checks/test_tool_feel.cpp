// Each tool feels as its law says: work of parting tissue, a needle that breaks through, a thread round its bend.
#include <gtest/gtest.h>

#include <cmath>

#include "devices/force/model_maker.h"
#include "tests/devices/flat_patient.h"

namespace limberg::bench {
namespace test_tool_feel {

/// The force loop on a plane, with what a tool feels, on a virtual clock.
struct Felt {
  explicit Felt(Tool tool, bool pressed = true) {
    model.facets = 2;
    model.facet[0] = {Vec3(-100, -100, 0), Vec3(100, -100, 0), Vec3(100, 100, 0)};
    model.facet[1] = {Vec3(-100, -100, 0), Vec3(100, 100, 0), Vec3(-100, 100, 0)};
    model.stiffness_N_mm = 0.5;
    const ToolFeel f = feel_of(tool, 0.8, 0.35);
    model.puncture_N = f.puncture_N, model.cutting_N = f.cutting_N, model.presses = f.presses;
    model.draw_N = f.draw_N, model.draw_N_mm = f.draw_N_mm, model.drawn = f.drawn_when_pressed && pressed;
    model.thread_N = pressed ? f.thread_N : 0, model.thread_friction = f.thread_friction;
  }
  /// There in a straight line, slowly, and what the hand has worked on the way (mJ).
  double go(const Vec3& to, double mm_s = 20) {
    const Vec3 from = tip;
    const int ticks = std::max(1, int((to - from).norm() / mm_s * 1000));
    double work = 0;
    for (int i = 1; i <= ticks; ++i, ++tick) {
      if (tick % 16 == 0) ++model.seq, model.t_ns = tick * 1'000'000, loop.take(model);
      const Vec3 next = from + double(i) / ticks * (to - from), before = loop.state().force_N;
      work -= before.dot(next - tip);
      tip = next;
      largest_N = std::max(largest_N, loop.tick(tick * 1'000'000, tip, true).force_N.norm());
    }
    return work;
  }
  void wait(int ms) {
    for (int i = 0; i < ms; ++i) go(tip);
  }
  const Vec3& force() const { return loop.state().force_N; }

  ForceLimits limits = [] {
    ForceLimits l;
    l.damping_N_s_mm = 0;
    return l;
  }();
  ForceLoop loop{limits};
  ForceModel model;
  Vec3 tip = Vec3(0, 0, 5);
  int64_t tick = 0;
  double largest_N = 0;
};

// The work of drawing a blade is the area that it parts times the toughness, less by what slicing saves.
TEST(ToolFeel, ABladeWorksByTheAreaThatItParts) {
  for (const double depth : {2.2, 2.6, 3.2}) {
    Felt f(Tool::scalpel);
    f.wait(800);
    f.go(Vec3(0, 0, -depth)), f.go(Vec3(6, 0, -depth));  // until it slides
    ASSERT_TRUE(f.loop.state().cut);
    const double work = f.go(Vec3(16, 0, -depth)) / 10;
    EXPECT_NEAR(work, 1.7 / 2 * depth, 0.02 * work);
    EXPECT_NEAR(-f.force().x(), work, 0.02 * work);
  }
  // On whole skin it slides as anything blunt.
  Felt f(Tool::scalpel);
  f.wait(800);
  f.go(Vec3(0, 0, -1.5)), f.go(Vec3(10, 0, -1.5));
  ASSERT_FALSE(f.loop.state().cut);
  EXPECT_LT(-f.force().x(), 0.25 * f.force().z());
}

TEST(ToolFeel, ADissectorIsHeldBackByItsWidthWhateverItsDepth) {
  double force[2];
  for (const int deep : {0, 1}) {
    Felt f(Tool::undermine);
    f.wait(800);
    f.go(Vec3(0, 0, deep ? -3 : -1.5)), f.go(Vec3(6, 0, f.tip.z()));
    force[deep] = -f.force().x();
    EXPECT_NEAR(f.go(Vec3(16, 0, f.tip.z())) / 10, 4.1 * 2 / 5, 0.03);
  }
  EXPECT_NEAR(force[0], force[1], 0.02);
  // Not pressed it slides over skin as anything blunt.
  Felt f(Tool::undermine, false);
  f.wait(800);
  f.go(Vec3(0, 0, -1.5)), f.go(Vec3(10, 0, -1.5));
  EXPECT_LT(-f.force().x(), 0.25 * f.force().z());
}

TEST(ToolFeel, ANeedleBreaksThroughAndAThreadIsBentRoundItsHole) {
  Felt f(Tool::suture);
  f.wait(800);
  f.model.thread_N = 0;
  f.go(Vec3(0, 0, -4.5), 5);
  EXPECT_NEAR(f.largest_N, 1.14 * 0.6 / 0.61, 0.03);
  EXPECT_NEAR(f.force().z(), 0.82 * 1.14 * 0.6 / 0.61, 0.03);
  EXPECT_FALSE(f.model.presses) << "a needle in skin is no button";
  f.go(Vec3(0, 0, 0.5)), f.wait(100);
  f.model.facets = 0;  // away from skin: the thread alone
  f.model.thread_N = 0.15;
  f.wait(40);
  f.go(Vec3(0, 0, 30));
  EXPECT_NEAR(-f.force().z(), 0.15, 0.002) << "straight out of its hole";
  f.go(Vec3(0, 0, 25));
  EXPECT_LT(f.force().norm(), 1e-9) << "slack";
  f.go(Vec3(60, 0, 1e-6)), f.go(Vec3(80, 0, 1e-6));
  EXPECT_NEAR(f.force().norm(), 0.15 * std::exp(0.3 * M_PI / 2), 0.003) << "bent by a right angle";
  EXPECT_NEAR(f.go(Vec3(90, 0, 1e-6)) / 10, 0.15 * std::exp(0.3 * M_PI / 2), 0.003);
  EXPECT_GT(f.loop.counts().least_energy_mJ, -0.15);
}

// Round and round, with each tool: nobody's hand is driven.
TEST(ToolFeel, NoToolGivesBackMoreThanItGot) {
  for (const Tool tool : {Tool::none, Tool::scalpel, Tool::undermine, Tool::excise, Tool::suture, Tool::scissors}) {
    Felt f(tool);
    f.wait(600);
    double energy = 0, least = 0;
    for (int round = 0; round < 12; ++round)
      for (const Vec3& to : {Vec3(3, 0, -2), Vec3(-3, 4, -2.5), Vec3(-4, -3, -1), Vec3(2, 2, 3)}) {
        energy += f.go(to, 60);
        least = std::min(least, energy);
      }
    EXPECT_GT(least, -0.2) << int(tool);
    EXPECT_GE(energy, -0.2) << int(tool);
  }
}

// The model that a tool is felt by is made of what the hand holds: on the flat patient, with and without its button.
TEST(ToolFeel, TheModelFollowsTheTool) {
  ForceModelMaker maker(ForceSourceSettings{}, nullptr);
  Snapshot skin = test::snapshot_of(test::flat_topology(12, 1));
  int64_t t = 0;
  const auto model = [&](Tool tool, bool pressed, const Vec3& tip) {
    ToolState hand;
    hand.tool = int32_t(tool), hand.pressed = pressed;
    ++skin.step, t += 16'000'000;
    maker.look(skin), maker.hold(hand);
    return *maker.make(t, tip, ForceState{});
  };
  EXPECT_EQ(model(Tool::none, true, Vec3(0, 0, -1)).puncture_N, 0);
  EXPECT_GT(model(Tool::scalpel, false, Vec3(0, 0, -1)).draw_N_mm, 0);
  EXPECT_FALSE(model(Tool::undermine, false, Vec3(0, 0, -1)).drawn);
  EXPECT_TRUE(model(Tool::undermine, true, Vec3(0, 0, -1)).drawn);
  EXPECT_EQ(model(Tool::suture, false, Vec3(3, 1, -1)).thread_N, 0);
  const ForceModel pierced = model(Tool::suture, true, Vec3(3, 1, -1));
  EXPECT_GT(pierced.thread_N, 0);
  EXPECT_LT((pierced.thread_from_mm - Vec3(3, 1, 0)).norm(), 1e-6);
  const ForceModel drawn = model(Tool::suture, true, Vec3(20, 1, 6));
  EXPECT_LT((drawn.thread_from_mm - Vec3(3, 1, 0)).norm(), 1e-6) << "its hole stays where it is";
  EXPECT_EQ(model(Tool::suture, false, Vec3(20, 1, 6)).thread_N, 0);
}

}  // namespace test_tool_feel
}  // namespace limberg::bench
