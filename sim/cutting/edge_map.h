#pragma once
// Which live faces meet at an edge (pair of points): 2 normally, 3 where a wall meets the skin, 4 where walls cross, 1
// at a crack front. Open addressing; faces at one edge are chained through their half-edges (3 * face + k).
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace limberg {

class EdgeMap {
 public:
  void reserve(size_t edges) {
    size_t n = 64;
    while (n < edges * 2) n *= 2;
    if (n > key_.size()) rehash(n);
  }
  /// Enters or removes the three edges of a face.
  void add(int32_t face, const std::array<int32_t, 3>& v) {
    if (next_.size() < size_t(face) * 3 + 3) next_.resize(size_t(face) * 3 + 3, -1);
    for (int k = 0; k < 3; ++k) {
      if ((used_ + 1) * 2 > key_.size()) grow();
      const size_t slot = find(v[size_t(k)], v[size_t(k + 1) % 3]);
      if (key_[slot] == kEmpty) key_[slot] = key(v[size_t(k)], v[size_t(k + 1) % 3]), head_[slot] = -1, ++used_;
      next_[size_t(face) * 3 + size_t(k)] = head_[slot];
      head_[slot] = face * 3 + k;
    }
  }
  void remove(int32_t face, const std::array<int32_t, 3>& v) {
    for (int k = 0; k < 3; ++k) {
      const size_t slot = find(v[size_t(k)], v[size_t(k + 1) % 3]);
      int32_t* at = &head_[slot];
      while (*at != face * 3 + k) at = &next_[size_t(*at)];
      *at = next_[size_t(*at)];
    }
  }
  /// First half-edge (3 * face + k) at this edge, -1 if there is none; then next().
  int32_t first(int32_t a, int32_t b) const {
    if (key_.empty()) return -1;
    const size_t slot = find(a, b);
    return key_[slot] == kEmpty ? -1 : head_[slot];
  }
  int32_t next(int32_t half_edge) const { return next_[size_t(half_edge)]; }

 private:
  static constexpr uint64_t kEmpty = ~uint64_t(0);
  static uint64_t key(int32_t a, int32_t b) {
    if (a > b) std::swap(a, b);
    return uint64_t(uint32_t(a)) << 32 | uint32_t(b);
  }
  size_t find(int32_t a, int32_t b) const {
    const uint64_t k = key(a, b);
    uint64_t h = k * 0x9e3779b97f4a7c15ull;
    h ^= h >> 32;
    size_t slot = size_t(h) & (key_.size() - 1);
    while (key_[slot] != kEmpty && key_[slot] != k) slot = (slot + 1) & (key_.size() - 1);
    return slot;
  }
  void grow() {  // edges without faces are dropped on the way
    size_t live = 0;
    for (size_t i = 0; i < key_.size(); ++i) live += key_[i] != kEmpty && head_[i] >= 0;
    size_t n = 64;
    while (n < (live + 1) * 4) n *= 2;
    rehash(n);
  }
  void rehash(size_t n) {
    std::vector<uint64_t> old_key(n, kEmpty);
    std::vector<int32_t> old_head(n, -1);
    old_key.swap(key_);
    old_head.swap(head_);
    used_ = 0;
    for (size_t i = 0; i < old_key.size(); ++i) {
      if (old_key[i] == kEmpty || old_head[i] < 0) continue;
      const size_t slot = find(int32_t(old_key[i] >> 32), int32_t(uint32_t(old_key[i])));
      key_[slot] = old_key[i];
      head_[slot] = old_head[i];
      ++used_;
    }
  }

  std::vector<uint64_t> key_;
  std::vector<int32_t> head_, next_;
  size_t used_ = 0;
};

}  // namespace limberg
