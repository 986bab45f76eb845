#pragma once
// A small generator of our own, so that the tests draw the same numbers everywhere (splitmix64).
#include <cstdint>

#include "sim/geometry/vec.h"

namespace limberg::test {

class Random {
 public:
  explicit Random(uint64_t seed) : s_(seed) {}
  uint64_t next() {
    uint64_t z = (s_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  double uniform(double lo = 0, double hi = 1) { return lo + (hi - lo) * double(next() >> 11) * 0x1p-53; }
  int32_t below(int32_t n) { return int32_t(next() % uint64_t(n)); }
  Vec3 vec(double half = 1) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }

 private:
  uint64_t s_;
};

}  // namespace limberg::test
