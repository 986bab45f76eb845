#pragma once
// Which parts of a stroke run along earlier walls (and deepen them), and which are free.
//
// The path is looked at every kStep. A sample runs along a wall when it lies within kSnap of its line on the skin, the
// path's direction over 3 mm is within 15 degrees of that line's, and so is the blade of the wall's. Short gaps count
// as along, and longer ones in which it stays beside walls (corners); short ways along are chance.
#include <span>
#include <vector>

#include "sim/cutting/arrangement/wall_map.h"
#include "sim/cutting/strokes/blade_build.h"

namespace limberg {

inline constexpr double kStep = 0.25;       // between samples of a stroke
inline constexpr size_t kWindow = 6;        // samples on either side that tell its direction: 3 mm in all
inline constexpr double kGap = 1.0;         // a hand leaves the line that it follows by so much and comes back
inline constexpr double kCorner = 3.5;      // at a corner of the wall the path's direction tells nothing for so long
inline constexpr double kLeastAlong = 3.0;  // shorter ways along a wall are chance

/// Per sample, arc length i * kStep: does it run along a wall, and how far to its left does the path lie?
struct AlongSamples {
  double length = 0;
  std::vector<uint8_t> along;
  std::vector<double> offset;
  double arc(size_t i) const { return double(i) * kStep < length ? double(i) * kStep : length; }
  /// The end of the block of equal samples that begins at i.
  size_t block_end(size_t i) const;
  /// Did the path pass from one side of the wall to the other between two samples? Then it crosses it at a small angle.
  bool drifts(size_t first, size_t last) const;
};
/// Near sharp corners a leaning blade of this depth may have been turned upright: there the wall may lean less.
AlongSamples samples_along(const BladeContext& context, const WallMap& walls, std::span<const Vec2> path, double lean,
                           double depth_mm);

}  // namespace limberg
