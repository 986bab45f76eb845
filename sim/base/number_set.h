#pragma once
// Numbers below a limit, each once: noted in any order, read in ascending order. Costs a bit per possible number.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace limberg {

class NumberSet {
 public:
  explicit NumberSet(size_t limit) : word_((limit + 63) / 64, 0) {}
  /// False when it was there already.
  bool add(int32_t i) {
    uint64_t& w = word_[size_t(i) / 64];
    const uint64_t bit = uint64_t(1) << (i & 63);
    if (w & bit) return false;
    w |= bit;
    return true;
  }
  bool has(int32_t i) const { return word_[size_t(i) / 64] >> (i & 63) & 1; }
  template <class List>
  void add_all(const List& list) {
    for (int32_t i : list) add(i);
  }
  std::vector<int32_t> ascending() const {
    size_t n = 0;
    for (uint64_t w : word_) n += size_t(std::popcount(w));
    std::vector<int32_t> list;
    list.reserve(n);
    for (size_t i = 0; i < word_.size(); ++i)
      for (uint64_t w = word_[i]; w; w &= w - 1) list.push_back(int32_t(64 * i) + std::countr_zero(w));
    return list;
  }

 private:
  std::vector<uint64_t> word_;
};

/// Sorts a list of numbers below `limit` and leaves each once.
inline void sort_unique(std::vector<int32_t>& list, size_t limit) {
  NumberSet set(limit);
  set.add_all(list);
  list = set.ascending();
}

}  // namespace limberg
