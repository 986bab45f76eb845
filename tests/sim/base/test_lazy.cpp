#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <new>
#include <thread>
#include <vector>

#include "sim/base/lazy.h"

namespace limberg {
namespace test_lazy {

TEST(Lazy, IsFoundOnceWhoeverAsksAndCopiesShareIt) {
  std::atomic<int> calls{0};
  const Lazy<std::vector<int>> lazy([&] {
    ++calls;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // so that the others come while it is being found
    return std::vector<int>{1, 2, 3};
  });
  EXPECT_EQ(calls, 0);
  std::vector<const std::vector<int>*> seen(4, nullptr);
  std::vector<std::thread> threads;
  for (size_t i = 0; i < seen.size(); ++i) threads.emplace_back([&, i, copy = lazy] { seen[i] = &copy.get(); });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(calls, 1);
  for (const auto* s : seen) EXPECT_EQ(s, &lazy.get());
  EXPECT_EQ(lazy.get(), (std::vector<int>{1, 2, 3}));
}

TEST(Lazy, GivesUpWhatItWasFoundFrom) {
  auto source = std::make_shared<int>(7);
  const Lazy<int> lazy([source] { return *source; });
  EXPECT_EQ(source.use_count(), 2);
  EXPECT_EQ(lazy.get(), 7);
  EXPECT_EQ(source.use_count(), 1);
}

TEST(Lazy, AnswersTheFirstThatSaysHowAndTriesAgainAfterAnException) {
  const Lazy<int> lazy;
#ifndef __SANITIZE_THREAD__  // its pthread_once waits for ever after an exception
  EXPECT_THROW(lazy.get([]() -> int { throw std::bad_alloc(); }), std::bad_alloc);
#endif
  EXPECT_EQ(lazy.get([] { return 5; }), 5);
  EXPECT_EQ(lazy.get([] { return 6; }), 5);
  EXPECT_EQ(lazy.get(), 5);
  EXPECT_EQ(Lazy<int>().get(), 0) << "nobody has said how";
  EXPECT_EQ(Lazy<int>(4).get(), 4);
}

}  // namespace test_lazy
}  // namespace limberg
