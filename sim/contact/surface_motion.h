#pragma once
// How far the surface moves, at most, against each place: so that nobody searches where nothing moves.
//
// What is carried by a cell copy moves as its eight nodes do: its motion lies in the box that theirs span. Space is parted
// into blocks; each block and those around it together have one box that holds the motions of all that is there. The
// farthest corner of that box from a place's own motion bounds how much nearer anything there can have come. Tissue that
// moves together does not come nearer. Cells are sorted into blocks anew before they have gone far.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/contact_surface.h"
#include "sim/workers.h"

namespace limberg {

class SurfaceMotion {
 public:
  static constexpr double kReach_mm = 4;  // what is farther from a place than this is not counted

  SurfaceMotion(const ContactSurface& surface, const FemModel& model);

  /// Takes the motion from the last call to this one. False when nothing has moved.
  bool measure(std::span<const Vec3f> u);
  /// A bound of the motion of all that is near a place against its own motion, own_mm, in that time.
  double apart(size_t place, const Vec3f& own_mm) const {
    const Box& b = near_[size_t(block_[carrier_of_place_[place]])];
    return double((own_mm - b.lo).cwiseAbs().cwiseMax((b.hi - own_mm).cwiseAbs()).norm());
  }

 private:
  struct Box {
    Vec3f lo, hi;
    void add(const Box& b) { lo = lo.cwiseMin(b.lo), hi = hi.cwiseMax(b.hi); }
  };
  void sort_into_blocks(std::span<const Vec3f> u);

  std::vector<std::array<int32_t, 8>> slot_;  // nodes of each cell copy that carries something, as places in node_
  std::vector<size_t> carrier_of_place_;
  std::vector<int32_t> node_;   // all nodes of these, ascending
  std::vector<Vec3f> then_;     // displacement of each at the last measure()
  std::vector<Vec3f> move_;     // of each since
  std::vector<Vec3> rest_;      // each at rest
  std::array<int32_t, 3> blocks_{1, 1, 1};
  std::vector<int32_t> block_;  // per carrier
  std::vector<Box> near_, spread_;  // per block
  double since_sorted_mm_ = 1e30;
};

}  // namespace limberg
