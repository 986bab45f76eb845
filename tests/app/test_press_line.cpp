// A force device feels the patient that is there: it asks the solver, takes what it says where that is about this
// place, and gives no energy away in the loop that both make.
#include <gtest/gtest.h>

#include <algorithm>

#include "app/assembly/world_patient.h"
#include "app/session/device_lane.h"
#include "app/session/press_line.h"
#include "app/session/solver_lane.h"
#include "devices/log_source.h"
#include "sim/body/block.h"
#include "tests/bench/felt_hand.h"

namespace limberg {
namespace test_press_line {

constexpr int kTicksPerStep = 16;

WorldSpec block() {
  Material skin, fat;
  skin.young_kPa = 60, fat.young_kPa = 18;
  BlockSpec b;
  b.size_mm = {60, 60, 10};
  b.skin_cell_mm = 1.5;
  b.layers = {{"skin", 2, skin}, {"fat", 8, fat}};
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = 4;
  return spec;
}

/// A hand that comes down onto the skin at (4, 3), presses `depth_mm` deep and then strokes and taps.
SimulatedHand hand(double top_mm, double depth_mm, bool restless) {
  SimulatedHand h;
  h.target = [=](double t) {
    Vec3 to(4, 3, top_mm + 5 - (5 + depth_mm) * std::min(1.0, t));
    if (restless && t > 1.5) to += Vec3(3 * std::sin(2 * t), 0, 2 * std::sin(9 * t));
    return to;
  };
  return h;
}

/// Device and solver lane on a virtual clock.
struct Loop {
  InlineWorkers workers;
  World world{block(), workers};
  WorldPatient patient{world, 10};
  std::unique_ptr<Channels> channels = std::make_unique<Channels>();
  Calibration calibration;
  DeviceFrontEnd front{calibration};
  DeviceLane device{front, *channels, false};
  SolverLane solver{patient, *channels, {}};
  FeltHand felt;

  Loop(const SimulatedHand& h, bool line)
      : felt(h, front, channels->press = line ? std::make_shared<PressLine>() : nullptr) {
    solver.start();
  }
  void run(double seconds) {
    for (int tick = 1; tick < int(seconds * 1000); ++tick) {
      device.tick(tick), felt.watch();
      if (tick % kTicksPerStep == 0) solver.step(tick);
    }
  }
};

TEST(PressLine, AForceIsThatOfThePatientAndNotOfAHalfSpace) {
  Loop with(hand(0, 4, false), true), without(hand(0, 4, false), false);
  with.run(3), without.run(3);
  ASSERT_TRUE(with.felt.force().loop().state().touching);
  EXPECT_GT(with.felt.force().answers(), 25);
  EXPECT_EQ(without.felt.force().answers(), 0);
  // What the world says at that place and depth is what the hand feels.
  PressAnswer told;
  Snapshot s;
  with.world.fill(s);
  const SurfaceIndex index;
  const SkinTouch under = index.closest(s, with.felt.tool().true_mm(), -1);
  const double depth = with.felt.force().loop().state().depth_mm;
  for (int i = 0; i < 8; ++i)
    told = with.world.press({s.topology_version, under.triangle, under.bary, under.normal, 1, depth}, 20);
  const double k = with.felt.force().model().stiffness_N_mm;
  EXPECT_NEAR(k / told.stiffness_N_mm, 1, 0.05);
  EXPECT_NEAR(with.felt.force().loop().state().force_N.norm(), k * depth,
              0.1 * k * depth);  // the coupling's spring lies in series
  // Fat below 2 mm of skin: softer than skin all the way down.
  EXPECT_LT(k, 0.9 * without.felt.force().model().stiffness_N_mm);
}

TEST(PressLine, NoEnergyComesFromAPatientThatAnswersLate) {
  Loop loop(hand(0, 4, true), true);
  loop.run(6);
  EXPECT_GT(loop.felt.force().answers(), 50);
  // The bound of a wall read in steps: K T / 2 times the sum of
  // the squares of the way per tick (Colgate 1995), and .1 mJ.
  EXPECT_GT(loop.felt.least_mJ, -0.15);
  EXPECT_LE(loop.felt.largest_step_N, 0.2 + 1e-9);
}

// With a scalpel in the hand the skin holds, breaks and gives way,
// and the cut begins where it broke; with another tool it holds.
TEST(PressLine, TheToolThatIsHeldIsFelt) {
  for (const Tool tool : {Tool::scalpel, Tool::hook}) {
    SimulatedHand firm = hand(0, 9, false);
    firm.stiffness_N_mm = 1;
    Loop loop(firm, true);
    ControlSample c;
    c.device_id = 901, c.t_ns = 1, c.tool = tool;
    c.value[kDepth] = 3;
    loop.front.add(std::make_unique<LogSource>(std::vector<Sample>{c}));
    double most = 0, last = 0;
    bool engaged = false;
    for (int tick = 1; tick < 2500; ++tick) {
      loop.device.tick(tick);
      if (tick % kTicksPerStep == 0) loop.solver.step(tick);
      last = loop.felt.force().loop().state().force_N.norm();
      most = std::max(most, last);
      engaged |= loop.device.hand().tool.pressed != 0;
    }
    const ForceSourceSettings set;
    if (tool == Tool::scalpel) {
      EXPECT_NEAR(most, set.puncture_N, 0.1);
      EXPECT_NEAR(last, set.cutting_N, 0.1);
    } else {
      EXPECT_GT(last, set.puncture_N);
    }
    EXPECT_EQ(engaged, tool == Tool::scalpel);
  }
}

TEST(PressLine, AnAnswerAboutAnotherSurfaceIsNotTaken) {
  Loop loop(hand(0, 4, false), true);
  loop.run(2);
  const int64_t answers = loop.felt.force().answers();
  ASSERT_GT(answers, 10);
  ASSERT_TRUE(loop.world.apply(Incise{{{-20, -20}, {-10, -20}}, 3}).done);
  loop.solver.step(2001),
      loop.solver.step(2002);  // the new surface is shown, and the question about the old one is dropped
  loop.device.tick(2003);
  EXPECT_EQ(loop.felt.force().answers(), answers);
  for (int tick = 2010; tick < 2060; tick += 10) loop.solver.step(tick), loop.device.tick(tick + 1);
  EXPECT_GT(loop.felt.force().answers(), answers);
}

}  // namespace test_press_line
}  // namespace limberg
