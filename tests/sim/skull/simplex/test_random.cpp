// Random operators, one after the other: every invariant after every one, Euler bookkeeping, exact undo.
#include <gtest/gtest.h>

#include <cstdlib>

#include "sim/skull/simplex/generators.h"
#include "sim/testing/random_operators.h"

namespace limberg::simplex {
namespace test_random {

void run(const Mesh& m, uint64_t seed, int64_t operations) {
  const RandomOperators r = random_operators(m, operations, seed);
  for (int i = 0; i < RandomOperators::kinds; ++i)
    std::printf("%s %lld done, %lld refused; ", RandomOperators::name[i], static_cast<long long>(r.done[size_t(i)]),
                static_cast<long long>(r.refused[size_t(i)]));
  std::printf("%lld stretches taken back\n", static_cast<long long>(r.undone));
  EXPECT_EQ(r.fault, "");
  EXPECT_EQ(r.operations, operations);
  for (int i = 0; i < RandomOperators::kinds; ++i) EXPECT_GT(r.done[size_t(i)], 0) << RandomOperators::name[i];
  EXPECT_GT(r.undone, 0);
}

// (LIMBERG_SIMPLEX_OPERATIONS=100000 for a long run.)
int64_t operations() {
  const char* s = std::getenv("LIMBERG_SIMPLEX_OPERATIONS");
  return s ? std::atoll(s) : 4000;
}

TEST(RandomOperators, OnASphere) { run(make_sphere({0, 0, 0}, 10, 2), 1, operations()); }
TEST(RandomOperators, OnATorus) { run(make_torus(30, 10, 16, 9), 2, operations()); }
TEST(RandomOperators, OnAPlane) { run(make_plane(30, 30, 2), 3, operations()); }

TEST(RandomOperators, TheSameTwice) {
  Mesh a = make_torus(30, 10, 16, 9), b = a;
  EXPECT_EQ(random_operators(a, 500, 9).hash, random_operators(b, 500, 9).hash);
}

}  // namespace test_random
}  // namespace limberg::simplex
