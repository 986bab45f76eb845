#pragma once
// Numbers below a limit, each once: noted in any order, read in ascending order. Costs a byte per possible number.
#include <algorithm>
#include <cstdint>
#include <vector>

namespace limberg {

class NumberSet {
 public:
  explicit NumberSet(size_t limit) : seen_(limit, 0) {}
  /// False when it was there already.
  bool add(int32_t i) {
    uint8_t& seen = seen_[size_t(i)];
    if (seen) return false;
    seen = 1;
    list_.push_back(i);
    return true;
  }
  template <class List>
  void add_all(const List& list) {
    for (int32_t i : list) add(i);
  }
  const std::vector<int32_t>& ascending() {
    std::sort(list_.begin(), list_.end());
    return list_;
  }

 private:
  std::vector<uint8_t> seen_;
  std::vector<int32_t> list_;
};

}  // namespace limberg
