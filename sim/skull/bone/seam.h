#pragma once
// The seam of two bones that were made one, smoothed.
//
// Where the two did not lie as they were cut, a join leaves steps and a saw-tooth along the line on which the rings
// meet. As the paper has it, the surface there moves by the internal force of a simplex mesh that smooths curvature
// (simplex/law.h): in a band about the seam, whose rim holds still. The surface is meant to keep what it encloses: what
// the force took away is given back along the normals of the band, most at the seam and nothing at its rim.
#include <span>

#include "sim/base/workers.h"
#include "sim/skull/simplex/edit.h"

namespace limberg::bone {

struct SeamReport {
  int32_t vertices = 0;      // that moved
  double farthest_mm = 0;    // so far
  double volume_change = 0;  // of the bone, relative; what is left of it
};

/// `seam`: vertices on both sides of it. Vertices on the walls of other cuts, on rims, and locked ones hold still. The
/// band reaches `band_mm` from the seam along edges. What it did is appended to `delta`.
SeamReport smooth_seam(simplex::Mesh& mesh, std::span<const int32_t> seam, double band_mm, Workers& workers,
                       simplex::Delta& delta);

}  // namespace limberg::bone
