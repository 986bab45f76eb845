#pragma once
// How far tissue lies in tissue: the overlap of the deformed
// surface with itself, found without asking who keeps it apart.
//
// The surface is closed, so the winding number of a place - exits minus entries along any ray
// from it - counts how often it is covered: 0 outside, 1 in the tissue, 2 where two parts of
// it overlap. Places looked at: points of all wound walls and of the skin that borders on
// them, about 1 mm apart, each moved a micrometre into its own tissue. Where the winding is 2
// or more, the depth is how far one must go through the overlap to get out of it: the
// shortest way along 17 directions within 60 degrees of the inward normal. (Between two walls
// that overlap evenly that is the overlap's thickness. The nearest way out at the edge of a
// part may be through its own side: depths there are read too small, never too large.)
#include <span>

#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

struct Penetration {
  double max_mm = 0;
  double p99_mm = 0;           // not exceeded on 99 % of the area looked at (as it is at rest)
  Vec3 at_mm = Vec3::Zero();   // deepest place, deformed
  double area_mm2 = 0;         // looked at, at rest
  double overlapping_mm2 = 0;  // of it, in other tissue by more than 0.02 mm
};

/// `x_mm` per view vertex. Nothing but zeros on a surface without walls.
Penetration penetration(const SurfaceView& view, std::span<const Vec3f> x_mm);

/// Winding number of a closed oriented surface around p by solid angles (Jacobson, Kavan and Sorkine-Hornung 2013): the
/// slow way, for tests and single places.
double winding_number(const SurfaceView& view, std::span<const Vec3f> x_mm, const Vec3& p_mm);

}  // namespace limberg
