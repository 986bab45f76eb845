#pragma once
// Boxes that move: which of them meet a box that is asked about.
//
// A tree with four children to a node, whose boxes lie side by side so that all
// are compared at once. Members follow each other along a curve through space
// (Morton's), made anew by sort(); any order gives the same answers, only slower.
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/base/node4.h"

namespace limberg {

class MovingBoxes {
 public:
  struct Box {
    v4 lo, hi;
  };

  MovingBoxes() = default;
  /// Over the boxes of these numbers, whose boxes refit() gives.
  explicit MovingBoxes(std::vector<int32_t> members);

  void sort(std::span<const Box> box);
  void refit(std::span<const Box> box);
  /// visit(i) for every member i whose box meets `where` (faces count), once each.
  template <class Visit>
  void meet(const Box& where, Visit&& visit) const;

 private:
  struct Four {  // per axis, a lane to each child; of one that is not there lo is above hi
    std::array<v4, 3> lo, hi;
  };
  struct At {
    int32_t level, index;
  };
  static constexpr size_t kStack = 64;  // three for each level of four times as many

  std::vector<int32_t> order_;
  std::vector<std::vector<Four>> level_;  // the leaves first
};

template <class Visit>
void MovingBoxes::meet(const Box& where, Visit&& visit) const {
  if (order_.empty()) return;
  std::array<v4, 3> lo, hi;
  for (size_t a = 0; a < 3; ++a) lo[a] = v4{} + where.lo[a], hi[a] = v4{} + where.hi[a];
  std::array<At, kStack> stack;
  size_t n = 0;
  stack[n++] = {int32_t(level_.size()) - 1, 0};
  while (n > 0) {
    const At at = stack[--n];
    const Four& f = level_[size_t(at.level)][size_t(at.index)];
    v4i out = {};
    for (size_t a = 0; a < 3; ++a) out |= (f.hi[a] < lo[a]) | (f.lo[a] > hi[a]);
    const v4i bit = ~out & v4i{1, 2, 4, 8};
    for (uint32_t meets = uint32_t(bit[0] | bit[1] | bit[2] | bit[3]); meets != 0; meets &= meets - 1) {
      const int32_t child = 4 * at.index + std::countr_zero(meets);
      if (at.level == 0)
        visit(order_[size_t(child)]);
      else
        stack[n++] = {at.level - 1, child};
    }
  }
}

}  // namespace limberg
