// The quality ladder against machines of known speed.
#include <gtest/gtest.h>

#include "render/quality.h"

namespace limberg {
namespace test_quality {

/// Frames on a machine where level k takes cost[k] ms; the level at the end and how often it changed.
struct Climb {
  int level = 0, changes = 0, frames_at[4]{};
};
Climb run(QualityLadder& ladder, std::array<double, 4> cost, int frames) {
  Climb r;
  for (int i = 0; i < frames; ++i) {
    const int at = ladder.level();
    ++r.frames_at[at];
    ladder.frame(cost[size_t(at)]);
    r.changes += ladder.level() != at;
  }
  r.level = ladder.level();
  return r;
}

TEST(QualityLadder, ClimbsWhereThereIsTime) {
  QualityLadder ladder(20, 3, 0);
  const Climb r = run(ladder, {2, 3, 5, 40}, 500);
  EXPECT_EQ(r.level, 2);  // the levels of a window, and no further
  EXPECT_EQ(r.changes, 2);
}

TEST(QualityLadder, StaysWhereTheNextWouldBeTooDear) {
  QualityLadder ladder(20, 3, 0);
  EXPECT_EQ(run(ladder, {12, 13, 14, 15}, 500).level, 0);  // twice 12 is above 0.7 x 20: not tried
  QualityLadder slow(20, 3, 0);
  EXPECT_EQ(run(slow, {300, 400, 500, 600}, 500).level, 0);  // below the first there is nothing
}

TEST(QualityLadder, ComesDownWhenTheMachineIsBusyAndGoesUpAgain) {
  QualityLadder ladder(20, 3, 0);
  EXPECT_EQ(run(ladder, {2, 3, 5, 40}, 500).level, 2);
  EXPECT_EQ(run(ladder, {15, 25, 40, 300}, 100).level, 0);
  EXPECT_EQ(run(ladder, {2, 3, 5, 40}, 500).level, 2);
}

TEST(QualityLadder, DoesNotFlicker) {
  QualityLadder ladder(20, 3, 0);
  // The second level looks cheap from the first and is not.
  const Climb r = run(ladder, {5, 30, 60, 90}, 6000);
  EXPECT_LE(r.changes, 2 * 8);  // tried after 30, 60, 120 ... frames: log2(6000 / 30) times
  EXPECT_GT(r.frames_at[0], 5700);
}

TEST(QualityLadder, OneSlowFrameIsNoReason) {
  QualityLadder ladder(20, 3, 0);
  run(ladder, {2, 3, 5, 40}, 500);
  for (int i = 0; i < 200; ++i) ladder.frame(i % 10 == 0 ? 200 : 5);
  EXPECT_EQ(ladder.level(), 2);
}

}  // namespace test_quality
}  // namespace limberg
