// Packets that were made to shut out the real stylus.
#include <gtest/gtest.h>

#include "devices/heard_streams.h"

namespace limberg {
namespace test_heard_streams {

constexpr int64_t kMs = 1'000'000;
constexpr HeardStreams::Name kStylus{0, 1};

struct Link {
  HeardStreams heard;
  int64_t out = 0;  // the number with which the last one taken goes on
  bool packet(int32_t device, int64_t seq, int64_t t_ms) {
    int64_t gap = 0;
    if (!heard.take({0, device}, seq, t_ms * kMs, true, gap)) return false;
    EXPECT_GE(gap, 0);
    EXPECT_LE(gap, HeardStreams::kMostLost);
    out = seq;
    return true;
  }
};

TEST(HeardStreams, OneNumberFarAheadSilencesNoStream) {
  for (const int64_t hostile : {INT64_MAX, INT64_MAX - 1, HeardStreams::kMostSeq, int64_t(1) << 40}) {
    Link link;
    int64_t last = -1;
    int taken_after = 0;
    for (int64_t t = 0; t < 3000; ++t) {
      if (t == 1000) link.packet(1, hostile, t);
      if (link.packet(1, 5000 + t, t)) {
        EXPECT_GT(link.out, last);
        last = link.out, taken_after += t > 1400;  // within 300 ms and a bit
      }
    }
    EXPECT_EQ(taken_after, 1599) << hostile;
    EXPECT_LT(last, 20'000) << hostile;
  }
}

TEST(HeardStreams, AHostileFirstNumberNeither) {
  Link link;
  EXPECT_FALSE(link.packet(1, INT64_MAX, 0));
  EXPECT_TRUE(link.packet(1, HeardStreams::kMostSeq, 0));
  EXPECT_FALSE(link.packet(1, 7, 100));
  EXPECT_TRUE(link.packet(1, 8, 400));
  EXPECT_EQ(link.out, HeardStreams::kMostSeq + 1);
}

TEST(HeardStreams, DevicesThatNobodyHasMakeRoom) {
  Link link;
  for (int32_t d = 0; d < int32_t(kMaxStreams); ++d) EXPECT_TRUE(link.packet(1000 + d, 50'000, d));
  EXPECT_FALSE(link.packet(1, 3, 100));
  EXPECT_FALSE(link.packet(1, 4, 9000));
  EXPECT_TRUE(link.packet(1, 5, 10'100));
  const int64_t first = link.out;
  EXPECT_GT(first, 50'000) << "a device that comes again must not count from a lower number";
  // One that is heard is never the one that goes, however many others come.
  for (int64_t t = 10'101; t < 40'000; ++t) {
    ASSERT_TRUE(link.packet(1, 5 + t - 10'100, t));
    if (t % 100 == 0) link.packet(int32_t(100'000 + t), 1, t);
  }
  EXPECT_EQ(link.out, first + 40'000 - 1 - 10'100);
}

TEST(HeardStreams, ASenderThatWasSilentBeginsAnew) {
  Link link;
  EXPECT_TRUE(link.packet(1, 500, 0));
  EXPECT_FALSE(link.packet(1, 0, 200)) << "without silence it is an old packet";
  EXPECT_TRUE(link.packet(1, 0, 400));
  EXPECT_EQ(link.out, 501);
  EXPECT_FALSE(link.packet(1, 0, 401)) << "twice";
  EXPECT_TRUE(link.packet(1, 1, 402));
  EXPECT_EQ(link.out, 502);
}

TEST(HeardStreams, AMessageWithoutChecksumIsADamagedOneOnceOneWasSeen) {
  HeardStreams heard;
  int64_t seq = 1, gap = 0;
  EXPECT_TRUE(heard.take(kStylus, seq, 0, true, gap));
  seq = 2;
  EXPECT_FALSE(heard.take(kStylus, seq, 1, false, gap));
}

TEST(HeardStreams, ADamagedFirstMessageShutsNobodyOut) {
  HeardStreams heard;
  int64_t seq = int64_t{1} << 35, gap = 0;
  EXPECT_TRUE(heard.take(kStylus, seq, 0, false, gap));
  seq = 1;
  EXPECT_TRUE(heard.take(kStylus, seq, 1, true, gap));
  EXPECT_EQ(gap, 0);
  EXPECT_EQ(seq, (int64_t{1} << 35) + 1) << "numbers grow for who records them";
  seq = 3;
  EXPECT_TRUE(heard.take(kStylus, seq, 2, true, gap));
  EXPECT_EQ(gap, 1);
}

}  // namespace test_heard_streams
}  // namespace limberg
