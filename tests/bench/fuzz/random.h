#pragma once
// A seeded generator of its own: the same numbers everywhere (SplitMix64, Steele et al. 2014).
#include <cstdint>

namespace limberg::fuzz {

struct Random {
  uint64_t state = 0;
  uint64_t next() {
    uint64_t z = state += 0x9e3779b97f4a7c15ull;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  double real(double lo, double hi) { return lo + (hi - lo) * double(next() >> 11) * 0x1p-53; }
  int below(int n) { return int(next() % uint64_t(n)); }
  bool one_in(int n) { return below(n) == 0; }
};

}  // namespace limberg::fuzz
