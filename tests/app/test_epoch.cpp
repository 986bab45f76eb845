// A version is freed on its owner's thread, and only when no reader can still hold it.
#include <gtest/gtest.h>

#include <thread>

#include "app/session/epoch.h"
#include "app/session/triple_buffer.h"

namespace limberg {
namespace test_epoch {

struct Thing {
  uint64_t version = 0;
  uint64_t payload = 1;           // plain memory that the deleter writes: ThreadSanitizer sees an order that is missing
  std::atomic<bool> alive{true};  // cleared by the deleter, so that a use after it is seen, not a crash
};

TEST(Versions, WaitForEveryReader) {
  Versions<int, 2> v;
  for (uint64_t i = 1; i <= 4; ++i) v.retain(i, std::make_shared<int>(int(i)));
  EXPECT_EQ(v.collect(), 0u);  // nobody has begun
  v.moved_to(0, 3);
  EXPECT_EQ(v.collect(), 0u);
  v.moved_to(1, 2);
  EXPECT_EQ(v.collect(), 1u);  // version 1
  v.retire(1);
  EXPECT_EQ(v.collect(), 1u);  // version 2
  v.retire(0);
  v.collect();
  EXPECT_EQ(v.kept(), 1u);  // the newest stays
}

TEST(Versions, MustGrow) {
  Versions<int, 1> v;
  const auto a = std::make_shared<int>(1);
  v.retain(5, a);
  EXPECT_NO_THROW(v.retain(5, a));
  EXPECT_THROW(v.retain(4, std::make_shared<int>(2)), std::logic_error);
}

/// One writer that publishes versions, one reader that borrows raw pointers and looks at them for a while.
/// `obey`: the writer asks the versions before it frees; otherwise it frees all but the newest (the planted defect).
uint64_t uses_after_free(bool obey, uint64_t versions, std::thread::id* freed_on, std::thread::id* owner) {
  std::vector<std::unique_ptr<Thing>> storage;  // outlives everything: "freed" things are only marked
  for (uint64_t i = 0; i <= versions; ++i) storage.push_back(std::make_unique<Thing>());
  TripleBuffer<const Thing*> newest;
  Versions<Thing, 1> kept;
  std::atomic<bool> stop{false};
  std::atomic<uint64_t> bad{0};
  std::atomic<uint64_t> reads{0};
  std::thread reader([&] {
    while (!stop) {
      if (newest.update()) kept.moved_to(0, newest.reading()->version);
      const Thing* t = newest.reading();
      for (int i = 0; t && i < 50; ++i) {
        if (!t->alive.load(std::memory_order_relaxed))
          ++bad;
        else if (t->payload != 1)
          ++bad;
        if (i % 10 == 0) std::this_thread::yield();
      }
      ++reads;
    }
    kept.retire(0);
  });
  *owner = std::this_thread::get_id();
  for (uint64_t i = 1; i <= versions; ++i) {
    storage[i]->version = i;
    kept.retain(i, std::shared_ptr<const Thing>(storage[i].get(), [&](const Thing* t) {
                  *freed_on = std::this_thread::get_id();
                  const_cast<Thing*>(t)->payload = 0;
                  const_cast<Thing*>(t)->alive.store(false, std::memory_order_relaxed);
                }));
    newest.writing() = storage[i].get();
    newest.publish();
    if (obey)
      kept.collect();
    else
      storage[i - 1]->alive = false;
    const uint64_t seen = reads;
    if (i % 8 == 0)
      while (reads == seen) std::this_thread::yield();
  }
  stop = true;
  reader.join();
  kept.collect();
  EXPECT_EQ(kept.kept(), 1u);
  return bad;
}

TEST(Versions, NothingIsUsedAfterItIsFreed) {
  std::thread::id freed_on, owner;
  EXPECT_EQ(uses_after_free(true, 4000, &freed_on, &owner), 0u);
  EXPECT_EQ(freed_on, owner);
}

TEST(Versions, TheTestSeesAPlantedDefect) {
  std::thread::id freed_on, owner;
  EXPECT_GT(uses_after_free(false, 4000, &freed_on, &owner), 0u);
}

}  // namespace test_epoch
}  // namespace limberg
