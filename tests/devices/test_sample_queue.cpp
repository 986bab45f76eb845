// Samples on their way from the thread that receives to the one that polls.
#include <gtest/gtest.h>

#include <vector>

#include "devices/message_codec.h"
#include "devices/sample_queue.h"

namespace limberg {
namespace test_sample_queue {

struct Kept : SampleSink {
  void on_sample(const Sample& s) override { samples.push_back(s); }
  std::vector<Sample> samples;
};

// A clock stands still for 1.3 s, as a paused machine's does, and leaps to where it would be: what was received before
// is stamped after it. A recording that takes a reading gives it back, or all that follows is lost.
TEST(SampleQueue, AReadingOnBothSidesOfALeapOfTheClockCanBeRecorded) {
  SampleQueue queue(8);
  Kept kept;
  constexpr int64_t kBefore = 700'000'000, kAfter = kBefore + 1'308'000'000;
  queue.poll(kAfter, kept);  // the poller has seen the leap, the receiver has not
  TrackerSample reading;
  reading.device_id = 1, reading.t_ns = kBefore, reading.true_ns = kBefore - 12'000'000;
  ASSERT_TRUE(queue.push(reading));
  queue.poll(kAfter + 1'000'000, kept);
  ASSERT_EQ(kept.samples.size(), 1u);
  const auto& got = std::get<TrackerSample>(kept.samples[0]);
  EXPECT_EQ(got.t_ns, kAfter + 1);
  EXPECT_EQ(got.true_ns, got.t_ns - kOldestReadingNs);
  TrackerSample back;
  EXPECT_EQ(to_sample(to_message(got), back, false), nullptr);
}

TEST(SampleQueue, WithoutALeapAReadingKeepsItsTime) {
  SampleQueue queue(8);
  Kept kept;
  TrackerSample reading;
  reading.t_ns = 5'000'000, reading.true_ns = -7'000'000;
  ASSERT_TRUE(queue.push(reading));
  queue.poll(6'000'000, kept);
  ASSERT_EQ(kept.samples.size(), 1u);
  EXPECT_EQ(std::get<TrackerSample>(kept.samples[0]).true_ns, -7'000'000);
}

}  // namespace test_sample_queue
}  // namespace limberg
