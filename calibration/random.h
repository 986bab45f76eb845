#pragma once
// Seeded random numbers for sampling, the same on every machine (splitmix64).
#include <cstddef>
#include <cstdint>

namespace limberg {

class SmallRandom {
 public:
  explicit SmallRandom(uint64_t seed) : state_(seed) {}
  size_t below(size_t n) {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return size_t((z ^ (z >> 31)) % n);
  }

 private:
  uint64_t state_;
};

}  // namespace limberg
