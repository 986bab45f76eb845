#pragma once
// Which copies of neighbouring cells belong together, sorted, and shared between versions by blocks of cells.
#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sim/base/shared_array.h"

namespace limberg {

struct Link {                 // copies joined through the square between `cell` and a + neighbour
  int32_t cell_axis = 0;      // 3 * cell + axis
  int32_t next = 0;           // the neighbour
  int16_t low = 0, high = 0;  // classes
  auto operator<=>(const Link&) const = default;
};

class LinkTable {
 public:
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

  /// The links of cell and axis = cell_axis, sorted.
  std::span<const Link> of(int32_t cell_axis) const {
    const size_t b = size_t(cell_axis) / kBlock, k = size_t(cell_axis) % kBlock;
    if (b >= block_.size() || !block_[b]) return {};
    const Block& block = *block_[b];
    return std::span(block.link).subspan(block.begin[k], block.begin[k + 1] - block.begin[k]);
  }

  /// `links` sorted.
  void assign(std::span<const Link> links) {
    block_.clear();
    size_ = 0;
    replace({}, links);
  }
  /// The links of these squares (cell and axis, ascending) become `fresh`, which is sorted and has no other squares'
  /// (with no squares given: adds them). Costs what it touches.
  void replace(std::span<const int32_t> squares, std::span<const Link> fresh);

  class const_iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using value_type = Link;
    using difference_type = ptrdiff_t;
    using pointer = const Link*;
    using reference = const Link&;
    const_iterator() = default;
    const_iterator(const LinkTable* t, size_t block) : t_(t), block_(block) { skip(); }
    reference operator*() const { return t_->block_[block_]->link[i_]; }
    pointer operator->() const { return &**this; }
    const_iterator& operator++() {
      ++i_;
      skip();
      return *this;
    }
    const_iterator operator++(int) {
      const_iterator was = *this;
      ++*this;
      return was;
    }
    bool operator==(const const_iterator&) const = default;

   private:
    void skip() {
      while (block_ < t_->block_.size() && (!t_->block_[block_] || i_ >= t_->block_[block_]->link.size()))
        ++block_, i_ = 0;
    }
    const LinkTable* t_ = nullptr;
    size_t block_ = 0, i_ = 0;
  };
  const_iterator begin() const { return {this, 0}; }
  const_iterator end() const { return {this, block_.size()}; }
  friend bool operator==(const LinkTable& a, const LinkTable& b) {
    return a.size_ == b.size_ && std::equal(a.begin(), a.end(), b.begin());
  }

 private:
  static constexpr size_t kBlock = 48;  // cell and axis: 16 cells
  struct Block {
    std::array<uint32_t, kBlock + 1> begin{};
    std::vector<Link> link;
  };
  SharedArray<std::shared_ptr<const Block>> block_;
  size_t size_ = 0;
};

}  // namespace limberg
