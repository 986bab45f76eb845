#pragma once
// For every element of a version, where it was in the version before: most are where they were.
//
// A cut keeps the numbers of all that was there and adds parts after them, so the list is the identity on a long first
// part, which is not stored, and a few numbers after it. -1: it was not there.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace limberg {

class ParentList {
 public:
  ParentList() = default;
  ParentList(std::vector<int32_t> parent) : rest_(std::move(parent)) {}
  static ParentList identity(size_t n) {
    ParentList p;
    p.same_ = n;
    return p;
  }

  size_t size() const { return same_ + rest_.size(); }
  bool empty() const { return size() == 0; }
  int32_t operator[](size_t i) const { return i < same_ ? int32_t(i) : rest_[i - same_]; }
  /// The first so many elements are their own parents (others may be, too).
  size_t same() const { return same_; }

  /// Of this version in the one before `middle`, which this one was made from.
  ParentList through(const ParentList& middle) const {
    ParentList out = identity(std::min(same_, middle.same_));
    for (size_t i = out.same_; i < size(); ++i) {
      const int32_t m = (*this)[i];
      out.rest_.push_back(m < 0 ? -1 : middle[size_t(m)]);
    }
    return out;
  }

  void push_back(int32_t parent) { rest_.push_back(parent); }
  void assign(size_t n, int32_t parent) {
    same_ = 0;
    rest_.assign(n, parent);
  }
  void set(size_t i, int32_t parent) {
    if (i < same_ && parent != int32_t(i)) {
      rest_ = flat();
      same_ = 0;
    }
    if (i >= same_) rest_[i - same_] = parent;
  }
  std::vector<int32_t> flat() const {
    std::vector<int32_t> all(size());
    for (size_t i = 0; i < all.size(); ++i) all[i] = (*this)[i];
    return all;
  }
  operator std::vector<int32_t>() const { return flat(); }
  /// The way back to a version of `n` elements: each returns from the first that came from it; -1: none did.
  ParentList reversed(size_t n) const {
    if (same_ >= n) return identity(n);
    std::vector<int32_t> back(n, -1);
    for (size_t i = size(); i-- > 0;)
      if (const int32_t p = (*this)[i]; p >= 0) back[size_t(p)] = int32_t(i);
    return back;
  }
  friend bool operator==(const ParentList& a, const ParentList& b) {
    bool same = a.size() == b.size();
    for (size_t i = std::min(a.same_, b.same_); same && i < a.size(); ++i) same = a[i] == b[i];
    return same;
  }

 private:
  size_t same_ = 0;
  std::vector<int32_t> rest_;
};

}  // namespace limberg
