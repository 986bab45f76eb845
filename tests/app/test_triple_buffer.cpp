// A value that passes through a triple buffer is never torn, never goes back, and the last one always arrives.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <memory>
#include <thread>
#include <utility>

#include "app/session/triple_buffer.h"

namespace limberg {
namespace test_triple_buffer {

constexpr int kWords = 64;
struct Payload {
  std::array<uint64_t, kWords> word{};
};

struct Seen {
  uint64_t values = 0, torn = 0, backwards = 0, last = 0;
  void take(uint64_t first, bool whole) { torn += !whole, backwards += first < last, last = first, ++values; }
};

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

// Every order in which the steps of a writer and of a reader can follow each other: the writer writes half a value,
// then the other half, then publishes; the reader asks for a newer value, then reads one half, then the other.
template <class Slots>
struct Interleaving {
  static constexpr int kWrites = 3, kReads = 3, kSteps = 3;
  struct State {
    Slots slots;
    Seen seen;
    uint64_t published = 0, half = 0;
    bool holds = false, missed = false;
  };
  Seen all;  // of every order
  uint64_t orders = 0, missed = 0;

  static void write(State& s, int step) {
    const uint64_t value = uint64_t(step / kSteps) + 1;
    if (step % kSteps == 0) s.slots.writing()[0] = value;
    if (step % kSteps == 1) s.slots.writing()[1] = value;
    if (step % kSteps == 2) s.slots.publish(), s.published = value;
  }
  static void read(State& s, int step) {
    if (step % kSteps == 0) {
      const bool newer = s.slots.update();
      s.holds |= newer;
      s.missed |= newer != (s.published > s.seen.last);
    }
    if (!s.holds) return;
    if (step % kSteps == 1) s.half = s.slots.reading()[0];
    if (step % kSteps == 2) s.seen.take(s.half, s.slots.reading()[1] == s.half);
  }
  // The order is given by the places of the reader's steps among all steps.
  void run() {
    constexpr int kAll = kSteps * (kWrites + kReads);
    for (uint32_t reader = 0; reader < 1u << kAll; ++reader) {
      if (std::popcount(reader) != kSteps * kReads) continue;
      const auto s = std::make_unique<State>();
      int writes = 0, reads = 0;
      for (int i = 0; i < kAll; ++i) reader >> i & 1 ? read(*s, reads++) : write(*s, writes++);
      all.values += s->seen.values, all.torn += s->seen.torn, all.backwards += s->seen.backwards;
      missed += s->missed, ++orders;
    }
  }
};

TEST(TripleBuffer, HoldsInEveryOrderOfSteps) {
  Interleaving<TripleBuffer<std::array<uint64_t, 2>>> test;
  test.run();
  EXPECT_EQ(test.orders, 48620u);  // 18 choose 9
  EXPECT_GT(test.all.values, test.orders);
  EXPECT_EQ(test.all.torn, 0u);
  EXPECT_EQ(test.all.backwards, 0u);
  EXPECT_EQ(test.missed, 0u) << "update() says that there is a newer value exactly when there is";
}

// The same over two slots, of which the writer takes the one that was not published last.
struct TwoSlots {
  std::array<uint64_t, 2> slot[2]{};
  int write = 0, newest = 1, read = 1;
  std::array<uint64_t, 2>& writing() { return slot[write]; }
  void publish() { newest = write, write = 1 - write; }
  bool update() { return std::exchange(read, newest) != newest; }
  const std::array<uint64_t, 2>& reading() const { return slot[read]; }
};
TEST(TripleBuffer, TheOrdersFindThatTwoSlotsAreTooFew) {
  Interleaving<TwoSlots> test;
  test.run();
  EXPECT_GT(test.all.torn, 0u);
}

// Two threads, for the order of memory (ThreadSanitizer). The writer goes on until the reader has come in between often
// enough: neither an idle core nor luck decides whether anything was tested.
TEST(TripleBuffer, NeverTornNeverBackwards) {
  constexpr uint64_t kEnough = 2000, kMostWrites = 500'000'000;
  auto buffer = std::make_unique<TripleBuffer<Payload>>();
  Seen seen;
  std::atomic<uint64_t> values{0}, last_written{0};
  std::thread reader([&] {
    for (;;) {
      const uint64_t end = last_written;
      if (end > 0 && seen.last >= end) return;
      if (buffer->update()) {
        const Payload& p = buffer->reading();
        seen.take(p.word[0], std::equal(p.word.begin() + 1, p.word.end(), p.word.begin()));
        values = seen.values;
      } else {
        std::this_thread::yield();
      }
    }
  });
  uint64_t i = 0;
  while (values < kEnough && i < kMostWrites) {
    buffer->writing().word.fill(++i);
    buffer->publish();
    if (i % 64 == 0) std::this_thread::yield();  // lets the reader in on a machine with one core free
  }
  last_written = i;
  reader.join();
  EXPECT_GE(seen.values, kEnough) << "the two threads never ran side by side";
  EXPECT_EQ(seen.torn, 0u);
  EXPECT_EQ(seen.backwards, 0u);
  EXPECT_EQ(seen.last, i);  // the newest value arrived
}

}  // namespace test_triple_buffer
}  // namespace limberg
