// Slow motion on a virtual clock: a solver whose steps take so long, as the solver's thread drives it, and the
// session's time beside the wall's. Nothing sleeps.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "app/session/pace_watch.h"
#include "app/session/slow_motion.h"

namespace limberg {
namespace test_slow_motion {

constexpr int64_t kMs = 1'000'000, kPeriod = 16 * kMs;

struct Outcome {
  int64_t skipped = 0, steps = 0;
  double behind_ms = 0;  // the session's time less that of the patient shown, at most
  double pace = 1;       // over the second half
  double slowest = 1;
  int64_t wall_ns = 0;
};

/// Steps of a session of `session_s`; the n-th takes took_ms(n) of the wall's time.
Outcome drive(double session_s, const std::function<double(int64_t)>& took_ms) {
  SlowedTime time;
  int64_t wall = 0, shown = 0, half_wall = -1, half_session = 0;
  Slowing slowing(&time, kPeriod, shown, wall);
  PaceOverASecond pace;
  Outcome out;
  const auto end = int64_t(session_s * 1e9);
  for (int64_t n = 1; time.at(wall) < end; ++n) {
    wall = std::max(wall, time.wall_at(n * kPeriod));
    int64_t late = time.at(wall) - n * kPeriod;
    const int64_t missed = slowing.given_up(late);
    out.skipped += missed, n += missed, late -= missed * kPeriod;
    const int64_t began = wall, done = wall + int64_t(took_ms(n) * 1e6);
    for (; wall < done; wall = std::min(done, wall + kMs)) pace.look(wall, time.at(wall));
    out.behind_ms = std::max(out.behind_ms, double(time.at(wall) - shown) / kMs);
    shown = n * kPeriod;
    slowing.ended(n * kPeriod, late, began, wall);
    ++out.steps;
    if (half_wall < 0 && time.at(wall) > end / 2) half_wall = wall, half_session = time.at(wall);
  }
  out.pace = double(time.at(wall) - half_session) / double(wall - half_wall);
  out.slowest = pace.slowest(), out.wall_ns = wall;
  return out;
}

TEST(SlowMotion, StepsThatFitTheirPeriodKeepRealTime) {
  const Outcome o = drive(20, [](int64_t) { return 13.0; });
  EXPECT_EQ(o.skipped, 0);
  EXPECT_NEAR(o.pace, 1, 1e-9);
  EXPECT_NEAR(o.slowest, 1, 1e-9);
  EXPECT_EQ(o.steps, 20'000 / 16);
}

// Of what the steps allow, nine tenths: 0.9 * 16 ms / T of the wall's pace.
TEST(SlowMotion, StepsThatTakeTooLongAreAllDoneAtThePaceThatTheyAllow) {
  for (const double took : {20.0, 32.0, 48.0, 70.0}) {
    const Outcome o = drive(20, [&](int64_t) { return took; });
    EXPECT_EQ(o.skipped, 0) << took;
    EXPECT_NEAR(double(o.steps), 20'000.0 / 16, 5) << took;
    EXPECT_NEAR(o.pace, 0.9 * 16 / took, 0.01) << took;
    EXPECT_LT(o.behind_ms, 75) << took << ": a lag begins to cost there";
    EXPECT_LE(o.slowest, o.pace + 0.01) << took;
  }
}

TEST(SlowMotion, BelowTheLeastPaceStepsAreSkipped) {
  const Outcome o = drive(20, [](int64_t) { return 110.0; });
  EXPECT_GT(o.skipped, 100);
  EXPECT_NEAR(o.pace, 0.2, 0.001);
  EXPECT_LT(o.behind_ms, 200 + 2 * 0.2 * 110 + 1);
  EXPECT_NEAR(double(o.steps + o.skipped), 20'000.0 / 16, 14) << "each period is either done or told as given up";
}

// A cut takes half a second: 50 ms at the wall's pace, the rest at a fifth; then it is made up for.
TEST(SlowMotion, OneLongStepIsBrakedAndForgotten) {
  const Outcome o = drive(20, [](int64_t n) { return n == 300 ? 500.0 : 6.0; });
  EXPECT_EQ(o.skipped, 0);
  EXPECT_NEAR(o.behind_ms, 50 + 0.2 * (500 - 34), 1.0) << "it began when the patient shown was 16 ms old";
  EXPECT_NEAR(o.pace, 1, 1e-9);
  EXPECT_NEAR(o.slowest, 1 - 0.8 * 0.466, 0.05);
  EXPECT_NEAR(double(o.wall_ns) * 1e-9, 20 + 0.8 * 0.466, 0.15);
}

TEST(SlowMotion, AtRandomLoadsNoStepIsLost) {
  uint64_t x = 88172645463325252u;
  const Outcome o = drive(120, [&](int64_t) {
    x ^= x << 13, x ^= x >> 7, x ^= x << 17;
    const double u = double(x >> 11) / double(uint64_t(1) << 53);
    return u < 0.01 ? 200 + 3e4 * u : 5 + 40 * u;  // one in a hundred takes 200 to 500 ms
  });
  EXPECT_EQ(o.skipped, 0);
  EXPECT_NEAR(double(o.steps), 120'000.0 / 16, 14);
  EXPECT_LT(o.behind_ms, SlowMotion::kMost_ns / kMs);
}

TEST(Slowing, WithoutSlowMotionItTouchesNothing) {
  Slowing none(nullptr, kPeriod, 0, 0);
  none.ended(kPeriod, 0, 0, 400 * kMs);
  none.let_go(500 * kMs);
  EXPECT_EQ(none.given_up(10 * kMs), 0);
}

TEST(Slowing, LetGoTheClockKeepsTheWallsPace) {
  SlowedTime time;
  Slowing slowing(&time, kPeriod, 0, 0);
  slowing.ended(kPeriod, 0, 16 * kMs, 400 * kMs);
  const int64_t there = time.at(500 * kMs);
  EXPECT_LT(there, 200 * kMs);
  slowing.let_go(500 * kMs);
  EXPECT_EQ(time.at(1500 * kMs), there + 1000 * kMs);
}

TEST(SlowWatch, SaysHowSlowItIsAndWhenItIsOver) {
  SlowWatch w;
  EXPECT_EQ(w.look(0, 1), "");
  EXPECT_EQ(w.look(10, 0.96), "") << "a flicker";
  EXPECT_EQ(w.look(20, 0.62), "slowed: 0.6 of real time");
  EXPECT_EQ(w.look(30, 0.4), "") << "not so soon";
  EXPECT_EQ(w.look(2030, 0.6), "") << "the same";
  EXPECT_EQ(w.look(2040, 0.4), "slowed: 0.4 of real time");
  EXPECT_EQ(w.look(6000, 0.97), "slowed: 0.9 of real time") << "never 1.0";
  EXPECT_EQ(w.look(9000, 0.99), "in real time again");
  EXPECT_EQ(w.look(12'000, 1), "");
}

TEST(PaceOverASecond, IsTheMeanOfTheLastSecond) {
  PaceOverASecond p;
  int64_t wall = 0, session = 0;
  const auto go = [&](int64_t ms, double pace) {
    for (int64_t i = 0; i < ms / 10; ++i) wall += 10 * kMs, session += int64_t(10e6 * pace), p.look(wall, session);
  };
  go(5000, 1);
  EXPECT_NEAR(p.pace(), 1, 1e-9);
  go(500, 0.4);
  EXPECT_NEAR(p.pace(), 0.7, 0.02);
  go(2000, 0.4);
  EXPECT_NEAR(p.pace(), 0.4, 1e-9);
  go(4000, 1);
  EXPECT_NEAR(p.pace(), 1, 1e-9);
  EXPECT_NEAR(p.slowest(), 0.4, 1e-9);
}

}  // namespace test_slow_motion
}  // namespace limberg
