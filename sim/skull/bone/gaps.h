#pragma once
// Gap and overlap between fragments that were cut from each other.
#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/shape.h"

namespace limberg::bone {

/// Share of a's wall (mm^2) that lies on b's wall at rest: within 0.3 mm, facing it. 0: no cut between them.
double seam_mm2(const FragmentShape& a, const FragmentShape& b);

/// b_in_a: from b's rest to a's rest, as they lie now. Distances are measured from
/// the triangles of a's wall that have lain on b's. The overlap's volume is summed
/// over columns, at most 64 x 64 over the box of what overlaps (about 1 % of it).
Gap measure_gap(const FragmentShape& a, const FragmentShape& b, const Eigen::Isometry3d& b_in_a);

}  // namespace limberg::bone
