// A value that passes through a triple buffer is never torn, never goes back, and the last one always arrives.
#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "app/session/triple_buffer.h"

namespace limberg {
namespace test_triple_buffer {

constexpr int kWords = 64;
struct Payload {
  std::array<uint64_t, kWords> word{};
};

struct Seen {
  uint64_t values = 0, torn = 0, backwards = 0, last = 0;
};

void check(const Payload& p, Seen& seen) {
  const uint64_t first = p.word[0];
  bool torn = false;
  for (const uint64_t w : p.word) torn |= w != first;
  seen.torn += torn;
  seen.backwards += first < seen.last;
  seen.last = first;
  ++seen.values;
}

TEST(TripleBuffer, StartsEmptyAndHandsOverTheNewest) {
  TripleBuffer<int> b;
  EXPECT_FALSE(b.update());
  b.writing() = 1, b.publish();
  b.writing() = 2, b.publish();
  ASSERT_TRUE(b.update());
  EXPECT_EQ(b.reading(), 2);
  EXPECT_FALSE(b.update());
  EXPECT_EQ(b.reading(), 2);  // stays until something newer comes
  for (int i = 3; i < 20; ++i) b.writing() = i, b.publish();
  ASSERT_TRUE(b.update());
  EXPECT_EQ(b.reading(), 19);
}

TEST(TripleBuffer, NeverTornNeverBackwards) {
  constexpr uint64_t kWrites = 200'000;
  auto buffer = std::make_unique<TripleBuffer<Payload>>();
  Seen seen;
  std::thread reader([&] {
    while (seen.last < kWrites)
      if (buffer->update())
        check(buffer->reading(), seen);
      else
        std::this_thread::yield();
  });
  for (uint64_t i = 1; i <= kWrites; ++i) {
    buffer->writing().word.fill(i);
    buffer->publish();
    if (i % 64 == 0) std::this_thread::yield();  // lets the reader in on a machine with one core free
  }
  reader.join();
  EXPECT_EQ(seen.torn, 0u);
  EXPECT_EQ(seen.backwards, 0u);
  EXPECT_EQ(seen.last, kWrites);  // the newest value arrived
  EXPECT_GT(seen.values, 1u);
}

#if !defined(__SANITIZE_THREAD__)
// The detector itself: the same traffic over a plain struct is
// torn. (With ThreadSanitizer this is a report, by design.)
TEST(TripleBuffer, ThePlainStructIsTorn) {
  struct Plain {
    volatile uint64_t word[kWords] = {};
  };
  auto shared = std::make_unique<Plain>();
  std::atomic<bool> stop{false};
  uint64_t torn = 0;
  std::thread reader([&] {
    for (uint64_t n = 0; n < 20'000'000 && torn == 0 && !stop; ++n) {
      const uint64_t first = shared->word[0];
      for (int i = 1; i < kWords; ++i) torn += shared->word[i] != first;
    }
    stop = true;
  });
  for (uint64_t i = 1; !stop; ++i)
    for (int w = 0; w < kWords; ++w) shared->word[w] = i;
  reader.join();
  EXPECT_GT(torn, 0u);
}
#endif

}  // namespace test_triple_buffer
}  // namespace limberg
