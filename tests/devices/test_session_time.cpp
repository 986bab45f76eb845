// Session time that runs slower than the wall's: its line against a closed form, its readers beside its writer, and the
// stamps of sources that read on threads of their own.
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>

#include "devices/session_time.h"

namespace limberg {
namespace test_session_time {

constexpr int64_t kMs = 1'000'000;

TEST(SlowedTime, IsTheWallsUntilItIsBent) {
  const SlowedTime t;
  for (const int64_t w : {-20 * kMs, int64_t(0), int64_t(1), 7 * kMs, int64_t(86'400) * 1'000'000'000}) {
    EXPECT_EQ(t.at(w), w);
    EXPECT_EQ(t.wall_at(w), w);
  }
}

TEST(SlowedTime, PassesAtItsPaceAndFromTheBrakeOnAtTheLeast) {
  SlowedTime t;
  t.bend(100 * kMs, 500, 130 * kMs);
  EXPECT_EQ(t.at(100 * kMs), 100 * kMs);
  EXPECT_EQ(t.at(140 * kMs), 120 * kMs);
  EXPECT_EQ(t.at(160 * kMs), 130 * kMs);
  EXPECT_EQ(t.at(210 * kMs), 140 * kMs) << "a fifth of 50 ms";
  EXPECT_EQ(t.at(90 * kMs), 95 * kMs) << "before the bend as if its pace had been that";
  EXPECT_EQ(t.wall_at(120 * kMs), 140 * kMs);
  EXPECT_EQ(t.wall_at(140 * kMs), 210 * kMs);
  t.bend(210 * kMs, 1000, SlowedTime::kNever);
  EXPECT_EQ(t.at(1210 * kMs), 1140 * kMs);
  t.bend(1210 * kMs, 1000, 1000 * kMs);  // the brake lies behind
  EXPECT_EQ(t.at(1310 * kMs), 1160 * kMs);
  EXPECT_EQ(t.wall_at(1160 * kMs), 1310 * kMs);
  t.bend(1310 * kMs, 50, SlowedTime::kNever);
  EXPECT_EQ(t.at(1410 * kMs), 1180 * kMs) << "no slower than a fifth";
  t.bend(1410 * kMs, 3000, SlowedTime::kNever);
  EXPECT_EQ(t.at(1420 * kMs), 1190 * kMs) << "and no faster than the wall";
}

TEST(SlowedTime, GrowsAndIsItsOwnInverseWhateverItsBends) {
  std::mt19937_64 dice(5);
  SlowedTime t;
  int64_t wall = 0, last = 0;
  for (int i = 0; i < 20'000; ++i) {
    wall += int64_t(dice() % (30 * kMs));
    const int64_t now = t.at(wall);
    ASSERT_GE(now, last);
    t.bend(wall, int64_t(200 + dice() % 801), now + int64_t(dice() % (60 * kMs)) - 10 * kMs);
    ASSERT_EQ(t.at(wall), now) << "a bend is no leap";
    last = now;
    const int64_t later = now + int64_t(dice() % (90 * kMs)), due = t.wall_at(later);
    ASSERT_GE(t.at(due), later);
    ASSERT_LE(t.at(due - 2 * SlowedTime::kWhole / SlowedTime::kLeast), later) << "and not much too late";
  }
}

struct Overtaken : SlowedTime {
  /// While it is read for the first time, `bends` bends follow, each at another pace.
  int64_t pace_read(int bends) {
    bool first = true;
    const Bend b = newest([&] {
      for (int i = 1; first && i <= bends; ++i) bend(i * kMs, 200 + i, i * kMs);
      first = false;
    });
    EXPECT_EQ(b.pace, b.wall_ns == 0 ? 1000 : 200 + b.wall_ns / kMs) << "half of one bend, half of another";
    EXPECT_EQ(b.brake_ns, b.wall_ns == 0 ? kNever : b.wall_ns) << bends;
    return b.pace;
  }
};

TEST(SlowedTime, AReaderThatIsOvertakenBeginsAgain) {
  for (int bends = 0; bends < 40; ++bends) {
    Overtaken t;
    const int64_t pace = t.pace_read(bends);
    EXPECT_EQ(pace, bends < 7 ? 1000 : 200 + bends) << "before that, what it began to read is still there";
  }
}

// At a steady half of the wall's pace every bend lies on one line.
TEST(SlowedTime, ReadersBesideTheWriterStayOnTheLine) {
  SlowedTime t;
  t.bend(0, 500, SlowedTime::kNever);
  std::atomic<bool> stop{false};
  std::atomic<int64_t> wall{0}, wrong{0};
  std::thread writer([&] {
    for (int64_t w = 0; !stop; w += 2000) t.bend(w, 500, SlowedTime::kNever), wall = w;
  });
  const auto read = [&] {
    for (int i = 0; i < 300'000; ++i) {
      const int64_t w = wall;
      if (t.at(w) != w / 2) ++wrong;
    }
  };
  std::thread one(read), two(read);
  one.join(), two.join();
  stop = true;
  writer.join();
  EXPECT_EQ(wrong, 0);
}

TEST(SourceTime, StampsBySessionTimeAlsoOfASessionThatGoesOn) {
  const auto slowed = std::make_shared<SlowedTime>();
  const SourceTime alone(1000), from_start(1000, slowed), goes_on(1000, slowed, 5000 * kMs);
  slowed->bend(5000 * kMs, 500, SlowedTime::kNever);
  EXPECT_EQ(alone.stamp_ns(alone.wall_ns(1000 + 8 * kMs)), 8 * kMs);
  EXPECT_EQ(from_start.stamp_ns(from_start.wall_ns(1000 + 5010 * kMs)), 5005 * kMs);
  EXPECT_EQ(goes_on.stamp_ns(goes_on.wall_ns(1000 + 10 * kMs)), 5 * kMs) << "its time 0 is when it goes on";
}

}  // namespace test_session_time
}  // namespace limberg
