#pragma once
// Where the cells of touchable tissue are now: which of them hold a place, and where in them it lies.
//
// Per copy a box, the middle of its eight nodes and the inverse of its map's slope there. The trilinear map is inverted by
// Newton's method with that slope (with fresh slopes where a cell is so skew that this does not suffice); the first estimate
// sends most copies away at once. A grid of boxes finds the copies around a place; it is made only when some place asks for its
// surroundings anew.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/rest_tissue.h"
#include "sim/fem/node4.h"

namespace limberg {

class MovingCells {
 public:
  MovingCells(const RestTissue& tissue, const FemModel& model);

  /// Takes the displacement (per node of the model); carried_normal() knows it at once, all else after refit().
  void move(std::span<const Vec3f> u);
  void refit(Workers& workers);
  /// For near(): copies by where their boxes are, as of the last refit.
  void sort();
  /// visit(c) for every copy that can say something whose box is within `within_mm` of that of `copy` along each axis.
  template <class Visit>
  void near(size_t copy, float within_mm, Visit&& visit) const;

  /// Is p within `beyond` edges of copy c? Then `at` is its place there: 0 to 1 along each edge in the cell itself. False in
  /// cells that are folded.
  bool invert(size_t c, const Vec3f& p, float beyond, Vec3& at) const;
  /// May it be? By its box alone, which is a little larger than the cell.
  bool may_hold(size_t c, const Vec3f& p, float within_mm) const {
    const Box& b = box_[c];
    const fem::v4 q = {p[0], p[1], p[2], 0};
    const fem::v4i out = (q < b.lo - within_mm) | (q > b.hi + within_mm);
    return (out[0] | out[1] | out[2]) == 0;
  }
  /// How copy c carries the normal N of a material plane at `at`: of unit length, or zero where the cell is folded.
  Vec3 carried_normal(size_t c, const Vec3& at, const Vec3& N) const;

 private:
  struct Box {
    fem::v4 lo, hi;
  };
  struct Inverse {
    fem::v4 middle;  // of the cell
    fem::v4 along[3];  // `at` - 1/2 = sum_a along[a] (p - middle)[a]
    bool sound = false;
  };
  static constexpr int32_t kMostSteps = 48;  // along an axis

  const RestTissue& tissue_;
  std::vector<fem::v4> rest_, now_;  // of the tissue's nodes
  std::vector<Box> box_;
  std::vector<Inverse> inverse_;
  std::array<float, 3> lo_{};
  float step_ = 1, least_step_ = 1;
  std::array<int32_t, 3> grid_{1, 1, 1};
  struct Member {  // with its box, so that looking through a row of the grid goes through memory in order
    Box box;
    int32_t copy = 0;
  };
  std::vector<Member> member_;
  std::vector<int32_t> begin_, step_of_;
  std::array<float, 3> widest_{};  // half a box in the grid, at most
};

// A copy stands in the grid where the middle of its box is; those whose box is wider than a step stand apart, so that a few
// stretched ones do not make everybody look farther.
template <class Visit>
void MovingCells::near(size_t copy, float within_mm, Visit&& visit) const {
  const fem::v4 lo = box_[copy].lo - within_mm, hi = box_[copy].hi + within_mm;
  const auto look = [&](int32_t first, int32_t last) {
    for (int32_t i = first; i < last; ++i) {
      const Member& m = member_[size_t(i)];
      const fem::v4i out = (m.box.hi < lo) | (m.box.lo > hi);
      if ((out[0] | out[1] | out[2]) == 0) visit(size_t(m.copy));
    }
  };
  std::array<int32_t, 3> from, to;
  for (size_t a = 0; a < 3; ++a) {
    from[a] = std::max(0, int32_t((lo[a] - lo_[a] - widest_[a]) / step_)), to[a] = std::min(grid_[a] - 1, int32_t((hi[a] - lo_[a] + widest_[a]) / step_));
  }
  for (int32_t z = from[2]; z <= to[2]; ++z)
    for (int32_t y = from[1]; y <= to[1]; ++y) {
      const size_t row = size_t(z * grid_[1] + y) * size_t(grid_[0]);
      look(begin_[row + size_t(from[0])], begin_[row + size_t(to[0]) + 1]);
    }
  look(begin_.back(), int32_t(member_.size()));
}

}  // namespace limberg
