#pragma once
// The blade aimed: where a contour's blade cannot go straight in.
//
// Along the normals a contour on an even shell meets the other table everywhere. Around the rim of an orbit it does
// not: the normals of the rim point into solid bone, those of the orbit's wall into the other orbit. A surgeon tilts
// the saw there, so that it comes out within the skull. So does this: at each place of the path the blade may go in any
// of kDirections directions up to kCone_deg off the normal, and the ones are taken that make the cut surface least.
// That is the least sum over the path of
//
//   1/2 (|x(i+1) - x(i)| + |e(i+1) - e(i)|) 1/2 (d(i) + d(i+1))   of the strip between two places, e: exits, d: depths
//   + kTurn |u(i+1) - u(i)|^2 d / 2                               of neighbouring directions u that differ
//   + kBack times the way that exits go back against the path     the ruled surface would fold there
//
// found by dynamic programming twice around the closed path (the middle of the two rounds does not know where they
// began). An exit is one on the other table: the way to it over the surface, from any place of the path, is kAround
// times as long as through the bone
// (what
// comes out of a rod's other side, beside the path or near it, is none). The directions are smoothed afterwards.
#include <string>
#include <vector>

#include "sim/skull/bone/drawn_path.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::bone {

struct Aim {
  std::string reason;            // why there is none: too many places see no other table
  std::vector<Vec3> inward;      // unit, for each place of the path
  std::vector<double> depth_mm;  // to the other table
};

/// Places that need more than deepest_mm are allowed up to
/// kLonger times that; for half of the path it has to be enough.
Aim aim_blade(const simplex::Mesh& mesh, const BoneSurface& bone, const DrawnPath& path, double deepest_mm);

inline constexpr int kDirections = 160;
inline constexpr double kCone_deg = 75, kAround = 2, kLonger = 1.5;

}  // namespace limberg::bone
