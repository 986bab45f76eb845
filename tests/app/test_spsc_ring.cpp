// Everything that goes into the ring comes out once and in order; what does not fit is refused and counted.
#include <gtest/gtest.h>

#include <thread>

#include "devices/spsc_ring.h"

namespace limberg {
namespace test_spsc_ring {

TEST(SpscRing, FullEmptyWrap) {
  SpscRing<int> r(4);
  ASSERT_EQ(r.capacity(), 4u);
  int v = 0;
  EXPECT_FALSE(r.pop(v));
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(r.push(10 * round + i));
    EXPECT_FALSE(r.push(99));
    for (int i = 0; i < 4; ++i) {
      ASSERT_TRUE(r.pop(v));
      EXPECT_EQ(v, 10 * round + i);
    }
    EXPECT_FALSE(r.pop(v));
  }
  EXPECT_EQ(r.lost(), 10u);
}

TEST(SpscRing, CapacityIsRoundedUp) {
  EXPECT_EQ(SpscRing<int>(5).capacity(), 8u);
  EXPECT_EQ(SpscRing<int>(0).capacity(), 2u);
}

struct Item {
  uint64_t n = 0;
  uint64_t copy[7] = {};
};

TEST(SpscRing, TwoThreadsInOrderNothingLostUncounted) {
  constexpr uint64_t kItems = 300'000;
  SpscRing<Item> r(256);
  uint64_t sum = 0, taken = 0, disorder = 0, torn = 0;
  std::atomic<bool> ended{false};
  std::thread consumer([&] {
    uint64_t last = 0;
    Item it;
    for (;;) {
      const bool no_more = ended.load();
      if (!r.pop(it)) {
        if (no_more) return;
        std::this_thread::yield();
        continue;
      }
      disorder += it.n <= last;
      for (const uint64_t c : it.copy) torn += c != it.n;
      last = it.n;
      sum += it.n, ++taken;
    }
  });
  uint64_t pushed_sum = 0;
  for (uint64_t i = 1; i <= kItems; ++i) {
    Item it;
    it.n = i;
    for (uint64_t& c : it.copy) c = i;
    if (r.push(it))
      pushed_sum += i;
    else if (i % 3 == 0)
      std::this_thread::yield();
  }
  ended = true;
  consumer.join();
  EXPECT_EQ(disorder, 0u);
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(sum, pushed_sum);
  EXPECT_EQ(taken + r.lost(), kItems);
}

}  // namespace test_spsc_ring
}  // namespace limberg
