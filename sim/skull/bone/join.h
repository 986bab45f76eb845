#pragma once
// Two bones made one (T3): the walls that face each other are opened again to mouths, the mouths are joined in pairs.
// Where the two lie as they were cut, spoke to spoke (the inverse of the cut); where they were moved, ring to ring
// across the gap.
#include <string>
#include <vector>

#include "sim/skull/simplex/edit.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::bone {

/// Joins the components of vertices a and b; b's places are first taken by `b_in_a` (rest of b to rest of a). Answers
/// with the reason when it cannot be done (nothing has changed then): no walls that face each other within kReach_mm,
/// mouths that cannot be paired, and what t3 refuses. `seam`: receives the vertices on both sides of where they meet.
std::string join_bones(simplex::Mesh& mesh, int32_t a, int32_t b, const Eigen::Isometry3d& b_in_a,
                       simplex::Delta& delta, std::vector<int32_t>& seam);
inline constexpr double kReach_mm = 15;

}  // namespace limberg::bone
