#pragma once
// Sorting by small whole numbers, in a time that grows with the count alone.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace limberg {

/// Sorts `v` by key(element), which is below 2^bits; equal keys
/// keep their order. `room`: working space, of any content.
template <class T, class Key>
void radix_sort(std::vector<T>& v, std::vector<T>& room, int bits, Key&& key) {
  if (v.size() < 24) {  // insertion
    for (size_t i = 1; i < v.size(); ++i) {
      const T x = v[i];
      const uint64_t k = key(x);
      size_t j = i;
      for (; j > 0 && key(v[j - 1]) > k; --j) v[j] = v[j - 1];
      v[j] = x;
    }
    return;
  }
  constexpr int kDigit = 8;
  room.resize(v.size());
  for (int shift = 0; shift < bits; shift += kDigit) {
    std::array<uint32_t, 1 << kDigit> at{};
    for (const T& x : v) ++at[key(x) >> shift & 255];
    uint32_t sum = 0;
    for (uint32_t& a : at) sum += a, a = sum - a;
    for (const T& x : v) room[at[key(x) >> shift & 255]++] = x;
    v.swap(room);
  }
}

/// Bits of a whole number: 0 for 0, 8 for 255.
inline int bits_of(uint64_t v) { return v == 0 ? 0 : 64 - __builtin_clzll(v); }

}  // namespace limberg
