// The share of time that pictures may take, against machines on which they cost a known part of the solver's speed.
#include <gtest/gtest.h>

#include "app/session/drawing_share.h"

namespace limberg {
namespace test_drawing_share {

constexpr int64_t kMs = 1'000'000;

// A solver that steps every 16 ms for `work_ms`, and pictures of `picture_ms` as often as they may be drawn. While one
// is drawn an iteration takes (1 + loss) of its time. Virtual time, a tenth of a millisecond a tick.
struct Machine {
  double loss = 0;
  int iterations = 20;
  double iteration_ms = 0.4, picture_ms = 40;

  struct Found {
    double lost = 0;   // of the solver's speed, over the second half
    double drawn = 0;  // of the time
    double share = 0, measured = -1;
  };
  Found run(DrawingShare& share, double seconds) const {
    constexpr int64_t kTick = kMs / 10;
    int64_t picture_until = 0, next_picture = 0;
    bool drawing = false, stepping = false;
    double left = 0, busy = 0, useful = 0, drawn = 0;
    const int64_t end = int64_t(seconds * 1e9);
    for (int64_t t = kTick; t < end; t += kTick) {
      if (drawing && t >= picture_until) {
        drawing = false;
        next_picture = std::max(next_picture + 33 * kMs, t + share.picture_ended(t, int64_t(picture_ms * 1e6)));
      }
      if (!drawing && t >= next_picture)
        drawing = true, next_picture = t, picture_until = t + int64_t(picture_ms * 1e6), share.picture_begins(t);
      if (!stepping && t / (16 * kMs) != (t - kTick) / (16 * kMs))
        stepping = true, left = iterations * iteration_ms, share.step_begins(t);
      if (stepping) {
        const double work = 0.1 / (drawing ? 1 + loss : 1);
        if (t > end / 2) busy += 0.1, useful += work;
        if ((left -= work) <= 0) stepping = false, share.step_ended(t, iterations);
      }
      if (drawing && t > end / 2) drawn += 0.1;
    }
    return {useful > 0 ? busy / useful - 1 : 0, drawn / (seconds * 500), share.share(), share.loss()};
  }
};

TEST(DrawingShare, TheSolverLosesNoMoreThanIsAllowed) {
  for (const double loss : {0.2, 0.4, 1.0, 2.0}) {
    DrawingShare share(0.15);
    const Machine::Found f = Machine{.loss = loss}.run(share, 20);
    EXPECT_LT(f.lost, 0.20) << loss;
    EXPECT_GT(f.drawn, 0.05) << loss;  // and there are pictures
    EXPECT_NEAR(f.measured, loss, 0.35 * loss) << loss;
  }
}

TEST(DrawingShare, WhereNothingIsLostPicturesTakeMostOfTheTime) {
  DrawingShare share(0.15);
  const Machine::Found f = Machine{.loss = 0.02}.run(share, 20);
  EXPECT_GT(f.drawn, 0.7);
  EXPECT_LT(f.lost, 0.05);
}

TEST(DrawingShare, AGraphicsCardIsNotHeldBack) {
  // The thread's own processor time is next to nothing, however long the picture takes.
  DrawingShare share;
  share.picture_begins(10 * kMs);
  EXPECT_LT(share.picture_ended(26 * kMs, kMs / 5), kMs);
}

TEST(DrawingShare, AtRestThereIsNothingToLose) {
  DrawingShare share(0.15);
  const Machine::Found f = Machine{.loss = 1.0, .iterations = 1}.run(share, 10);
  EXPECT_EQ(f.share, 1);
  EXPECT_GT(f.drawn, 0.9);
}

TEST(DrawingShare, AMachineThatChangesIsMeasuredAnew) {
  DrawingShare share(0.15);
  Machine{.loss = 0.01}.run(share, 10);
  const Machine::Found worse = Machine{.loss = 1.0}.run(share, 30);  // another program has taken a core
  EXPECT_LT(worse.lost, 0.25);
  const Machine::Found better = Machine{.loss = 0.01}.run(share, 30);
  EXPECT_GT(better.drawn, 0.6);
}

}  // namespace test_drawing_share
}  // namespace limberg
