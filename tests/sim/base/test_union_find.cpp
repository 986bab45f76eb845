#include <gtest/gtest.h>

#include <random>

#include "sim/base/union_find.h"

namespace limberg {
namespace test_union_find {

TEST(UnionFind, SetsAreThoseOfANaiveLabelling) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    const int n = 1 + int(random() % 60);
    UnionFind sets{size_t(n)};
    std::vector<int> label(static_cast<size_t>(n));
    for (int i = 0; i < n; ++i) label[size_t(i)] = i;
    for (int step = 0; step < n; ++step) {
      const auto a = int32_t(random() % unsigned(n)), b = int32_t(random() % unsigned(n));
      const int low = std::min(label[size_t(a)], label[size_t(b)]), high = std::max(label[size_t(a)], label[size_t(b)]);
      EXPECT_EQ(sets.unite(a, b), low != high);
      for (int& l : label)
        if (l == high) l = low;
      for (int32_t i = 0; i < n; ++i) {
        EXPECT_EQ(sets.find(i), label[size_t(i)]) << "the root is the smallest member";
        EXPECT_EQ(sets.same(i, a), label[size_t(i)] == label[size_t(a)]);
      }
    }
  }
}

TEST(UnionFind, ResetPartsEverythingAgain) {
  UnionFind sets(4);
  sets.unite(0, 3);
  sets.reset(6);
  EXPECT_EQ(sets.size(), 6u);
  for (int32_t i = 0; i < 6; ++i) EXPECT_EQ(sets.find(i), i);
}

// A chain of a million: a root is found without recursion, and in time that does not grow with the chain's length.
TEST(UnionFind, LongChainsAreHalved) {
  constexpr int32_t n = 1'000'000;
  UnionFind sets(n);
  for (int32_t i = n - 1; i > 0; --i) sets.unite(i, i - 1);
  for (int32_t i = 0; i < n; ++i) ASSERT_EQ(sets.find(i), 0);
}

}  // namespace test_union_find
}  // namespace limberg
