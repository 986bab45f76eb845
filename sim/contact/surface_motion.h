#pragma once
// How far the surface moves, at most, against each cell copy of it: so that nobody searches where nothing moves.
//
// What is carried by a cell copy moves as its eight nodes do: its motion lies in
// the box that theirs span. Space is parted into blocks; each block and those
// around it together have one box that holds the motions of all that is there.
// The farthest corner of that box from the box of a copy's own motion bounds how
// much nearer anything there can have come. Tissue that moves together does not
// come nearer. Cells are sorted into blocks anew before they have gone far.
// Against single copies, known to be near, the bound is much closer.
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/base/node4.h"
#include "sim/contact/rest_tissue.h"

namespace limberg {

class SurfaceMotion {
 public:
  static constexpr double kReach_mm = 3;  // what is farther from a copy's tissue than this is not counted

  SurfaceMotion(const RestTissue& tissue, const FemModel& model);

  /// Takes the motion from the last call to this one. False when nothing has moved.
  bool measure(std::span<const Vec3f> u);
  /// How far the node that has moved most went in that time.
  double most_mm() const { return most_mm_; }
  /// A bound of how much nearer to a kept copy anything that is near it has come in that time.
  double apart(size_t copy) const { return double(std::sqrt(move_of_[copy].farthest2(near_[size_t(block_[copy])]))); }
  /// The same of one other copy alone, squared.
  float apart2(size_t copy, size_t other) const { return move_of_[copy].farthest2(move_of_[other]); }

 private:
  struct Box {
    v4 lo, hi;
    void add(const Box& b) { lo = b.lo < lo ? b.lo : lo, hi = b.hi > hi ? b.hi : hi; }
    float farthest2(const Box& b) const {
      const v4 up = b.hi - lo, down = hi - b.lo, d = up > down ? up : down;  // one of them is not negative
      const v4 d2 = d * d;
      return d2[0] + (d2[1] + d2[2]);
    }
  };
  void sort_into_blocks(std::span<const Vec3f> u);

  const RestTissue& tissue_;
  std::vector<v4> then_;    // displacement of each at the last measure()
  std::vector<v4> move_;    // of each since
  std::vector<Vec3> rest_;  // each at rest
  std::array<int32_t, 3> blocks_{1, 1, 1};
  std::vector<int32_t> block_;      // per kept copy
  std::vector<Box> move_of_;        // each one's
  std::vector<Box> near_, spread_;  // per block
  double since_sorted_mm_ = 1e30, most_mm_ = 0;
};

}  // namespace limberg
