#pragma once
// Where the cells of touchable tissue are now: which of them hold a place, and where in them it lies.
//
// Per copy its box, that of what lies beside it too, the middle of its eight nodes and the inverse of its map's slope
// there. The trilinear map is inverted by
// Newton's method with that slope (with fresh slopes where a cell is so skew that this does not suffice); the first
// estimate sends most copies away at once. A tree of the boxes finds the copies around a place.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/base/node4.h"
#include "sim/contact/moving_boxes.h"
#include "sim/contact/rest_tissue.h"

namespace limberg {

class MovingCells {
 public:
  static constexpr float kAhead_mm = 0.6f;  // so far from a copy's box nothing is beside it any more

  MovingCells(const RestTissue& tissue, const FemModel& model);

  /// Takes the displacement (per node of the model); carried_normal() knows it at once, all else after refit().
  void move(std::span<const Vec3f> u);
  void refit(Workers& workers);
  /// So that near() and around() are quick: wanted when copies have gone far since the last time.
  void sort() { tree_.sort(reach_); }
  /// visit(c) for every copy that can say something whose box is within `within_mm` of that of `copy` along each axis.
  template <class Visit>
  void near(size_t copy, float within_mm, Visit&& visit) const;
  /// The same of every copy that a point between lo and hi may lie in or beside.
  template <class Visit>
  void around(const Vec3f& lo, const Vec3f& hi, Visit&& visit) const {
    tree_.meet({v4{lo[0], lo[1], lo[2], 0}, v4{hi[0], hi[1], hi[2], 0}}, [&](int32_t c) { visit(size_t(c)); });
  }

  /// Is p within `beyond` edges of copy c? Then `at` is its place there: 0 to 1 along each edge in the cell itself.
  /// False in cells that are folded.
  bool invert(size_t c, const Vec3f& p, float beyond, Vec3& at) const;
  /// May it be? By boxes alone, which are a little larger than what they hold. `beside`: within kBeyond and kAhead_mm.
  bool may_hold(size_t c, const Vec3f& p, bool beside) const {
    const MovingBoxes::Box& b = beside ? reach_[c] : box_[c];
    const v4 q = {p[0], p[1], p[2], 0};
    const v4i out = (q < b.lo) | (q > b.hi);
    return (out[0] | out[1] | out[2]) == 0;
  }
  /// How copy c carries the normal N of a material plane at `at`: of unit length, or zero where the cell is folded.
  Vec3 carried_normal(size_t c, const Vec3& at, const Vec3& N) const;

 private:
  struct Inverse {
    v4 middle;    // of the cell
    v4 along[3];  // `at` - 1/2 = sum_a along[a] (p - middle)[a]
    bool sound = false;
  };
  const RestTissue& tissue_;
  std::vector<v4> rest_, now_;                 // of the tissue's nodes
  std::vector<MovingBoxes::Box> box_, reach_;  // of the cell; of what is beside it too
  std::vector<Inverse> inverse_;
  MovingBoxes tree_;  // of reach_, of those that can say something
};

template <class Visit>
void MovingCells::near(size_t copy, float within_mm, Visit&& visit) const {
  const MovingBoxes::Box where{box_[copy].lo - within_mm, box_[copy].hi + within_mm};
  tree_.meet(where, [&](int32_t c) {
    const MovingBoxes::Box& b = box_[size_t(c)];
    const v4i out = (b.hi < where.lo) | (b.lo > where.hi);
    if ((out[0] | out[1] | out[2]) == 0) visit(size_t(c));
  });
}

}  // namespace limberg
