#pragma once
// How far the surface moves, at most, around each place: so that nobody searches where nothing moves.
//
// What is carried by a cell copy moves no farther than the farthest of its eight nodes. The largest motion in each block of
// space and in the blocks around it bounds that of all that could come near a place there. Cells are sorted into blocks
// anew before anything has moved by kTrusted_mm.
#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/contact_surface.h"
#include "sim/workers.h"

namespace limberg {

class SurfaceMotion {
 public:
  static constexpr double kTrusted_mm = 1;

  SurfaceMotion(const ContactSurface& surface, const FemModel& model);

  /// The largest motion of all since the last call, in mm; everything the first time. When it is more than kTrusted_mm,
  /// near() is that of all.
  double measure(std::span<const Vec3f> u, Workers& workers);
  /// The largest motion of a place and of whatever was within some 4 mm of it, from the last measure() but one to the last.
  double near(size_t place) const { return block_move_[size_t(block_[carrier_of_place_[place]])]; }

 private:
  void sort_into_blocks(std::span<const Vec3f> u);
  std::vector<std::array<int32_t, 8>> slot_;  // nodes of each cell copy that carries something, as places in node_
  std::vector<size_t> carrier_of_place_;
  std::vector<int32_t> node_;   // all nodes of these, ascending
  std::vector<Vec3f> then_;     // displacement of each at the last measure()
  std::vector<Vec3> rest_;      // each at rest
  std::vector<float> move_;     // per node_
  std::array<int32_t, 3> blocks_{1, 1, 1};
  std::vector<int32_t> block_;  // per carrier
  std::vector<double> block_move_, spread_;
  double since_sorted_mm_ = 1e30;
};

}  // namespace limberg
