// A belt does one thing after another on its own thread, and keeps neither side waiting longer than it must.
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "app/session/belt.h"

namespace limberg {
namespace test_belt {

TEST(Belt, DoesAllInOrderOnOneThreadOfItsOwn) {
  std::vector<int> done;
  std::vector<std::thread::id> on;
  {
    Belt<int> belt([&] { on.push_back(std::this_thread::get_id()); }, [&](int& k) { done.push_back(k); },
                   [&] { on.push_back(std::this_thread::get_id()); });
    for (int k = 0; k < 100; ++k) belt.put(k);
    belt.stop();
    for (int k = 0; k < 100; ++k) EXPECT_EQ(done.at(size_t(k)), k);
  }
  ASSERT_EQ(on.size(), 2u);
  EXPECT_EQ(on[0], on[1]);
  EXPECT_NE(on[0], std::this_thread::get_id());
}

TEST(Belt, NeverHasMoreThanTwoWaiting) {
  std::atomic<int> put{0}, most{0}, done{0};
  Belt<int> belt([] {},
                 [&](int&) {
                   std::this_thread::yield();
                   most = std::max(most.load(), put.load() - done.load());
                   ++done;
                 },
                 [] {});
  for (int k = 0; k < 1000; ++k) ++put, belt.put(k);
  belt.stop();
  EXPECT_EQ(done, 1000);
  EXPECT_LE(most, int(Belt<int>::kWaiting) + 2);  // those that wait, the one in work, and the one being handed over
}

TEST(Belt, WhatGoesWrongIsThrownToWhoHandsOver) {
  EXPECT_THROW(Belt<int>([] { throw std::runtime_error("no picture"); }, [](int&) {}, [] {}), std::runtime_error);
  int worked = 0;
  Belt<int> belt([] {}, [&](int& k) { ++worked, k == 3 ? throw std::runtime_error("full") : void(); }, [] {});
  EXPECT_THROW(
      {
        for (int k = 0; k < 1000; ++k) belt.put(k);
        belt.stop();
      },
      std::runtime_error);
  EXPECT_EQ(worked, 4) << "what comes after it is passed over";
  // Nobody asks for the end: it ends all the same.
  {
    Belt<int> left([] {}, [](int&) {}, [] {});
    left.put(1);
  }
}

}  // namespace test_belt
}  // namespace limberg
