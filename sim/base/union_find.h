#pragma once
// Disjoint sets of the numbers 0 to n - 1 (Tarjan 1975), with path halving. The smallest member of a set is its root,
// so that numbering sets by their roots does not depend on the order in which they were united.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace limberg {

class UnionFind {
 public:
  UnionFind() = default;
  explicit UnionFind(size_t n) { reset(n); }

  /// Every number is a set of its own. The memory stays.
  void reset(size_t n) {
    parent_.resize(n);
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  /// The smallest member of its set.
  int32_t find(int32_t a) {
    while (parent_[size_t(a)] != a) a = parent_[size_t(a)] = parent_[size_t(parent_[size_t(a)])];
    return a;
  }
  /// False when both were in one set already.
  bool unite(int32_t a, int32_t b) {
    a = find(a), b = find(b);
    if (a == b) return false;
    parent_[size_t(std::max(a, b))] = std::min(a, b);
    return true;
  }
  bool same(int32_t a, int32_t b) { return find(a) == find(b); }
  size_t size() const { return parent_.size(); }

 private:
  std::vector<int32_t> parent_;
};

}  // namespace limberg
