#pragma once
// The cut rings of a fragment as curves, for sorting.
#include <vector>

#include "sim/skull/simplex/mesh.h"

namespace limberg::bone {

/// A closed curve, surface on its left.
struct Ring {
  std::vector<Vec3> corner_mm;  // as in the mesh
  // At equal steps along it:
  std::vector<Vec3> x_mm, tangent, normal;  // normal of the surface beside it, across the tangent; both over about 6 mm
  double step_mm = 0;
  double noise_mm = 0;  // standard deviation of its corners, each way, as they jump about
  double length_mm() const { return step_mm * double(x_mm.size()); }
};

/// All rings of a mesh of one piece, rings shorter than 10 mm left out.
std::vector<Ring> cut_rings(const simplex::Mesh& mesh);

}  // namespace limberg::bone
