#pragma once
// A short list of numbers per key, shared between versions (shared_array.h): the copies of a lattice cell, the
// triangles that descend from a triangle. Most keys have at most one number, which needs no list.
#include <cstdint>
#include <span>
#include <utility>

#include "sim/base/shared_array.h"

namespace limberg {

class ShortLists {
 public:
  ShortLists() = default;
  explicit ShortLists(size_t keys) : head_(keys) {}
  size_t keys() const { return head_.size(); }
  void resize(size_t keys) { head_.resize(keys); }
  int32_t count(size_t key) const { return head_[key].count; }
  int32_t at(size_t key, int32_t i) const {
    const Head h = head_[key];
    return h.count == 1 ? h.first : more_[size_t(h.first + i)];
  }
  /// Longer lists that are replaced leave their place unused: a little of what is touched, until all is made anew.
  void set(size_t key, std::span<const int32_t> list) {
    const Head h = std::as_const(head_)[key];
    bool same = size_t(h.count) == list.size();
    for (int32_t i = 0; same && i < h.count; ++i) same = at(key, i) == list[size_t(i)];
    if (same) return;
    if (list.size() < 2) {
      head_[key] = {list.empty() ? -1 : list[0], int32_t(list.size())};
      return;
    }
    if (list.size() > size_t(h.count) || h.count < 2) {
      head_[key] = {int32_t(more_.size()), int32_t(list.size())};
      for (int32_t v : list) more_.push_back(v);
      return;
    }
    for (size_t i = 0; i < list.size(); ++i) more_.set(size_t(h.first) + i, list[i]);
    head_[key] = {h.first, int32_t(list.size())};
  }
  friend bool operator==(const ShortLists& a, const ShortLists& b) {
    bool same = a.keys() == b.keys();
    for (size_t k = 0; same && k < a.keys(); ++k) {
      same = a.count(k) == b.count(k);
      for (int32_t i = 0; same && i < a.count(k); ++i) same = a.at(k, i) == b.at(k, i);
    }
    return same;
  }

 private:
  struct Head {
    int32_t first = -1;  // the number itself when there is one, else where the list begins
    int32_t count = 0;
    bool operator==(const Head&) const = default;
  };
  SharedArray<Head> head_;
  SharedArray<int32_t> more_;
};

}  // namespace limberg
