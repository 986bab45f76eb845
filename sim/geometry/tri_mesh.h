#pragma once
// An indexed triangle mesh: the rest surface of a body, as loaded or generated.
#include <cstdint>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// What a triangle of the body's original surface is.
enum class SurfaceTag : uint8_t {
  skin = 0,   // free, textured, can be incised
  fixed = 1,  // deep or lateral side, held in place
  free = 2    // other free surface
};

/// Triangles are counter-clockwise seen from outside. uv and tag are empty or one entry per triangle.
struct TriMesh {
  std::vector<Vec3> X_mm;
  std::vector<Tri> tri;
  std::vector<std::array<Eigen::Vector2f, 3>> uv;  // per corner, so seams survive
  std::vector<SurfaceTag> tag;
};

}  // namespace limberg
