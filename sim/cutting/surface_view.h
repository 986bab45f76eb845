#pragma once
// The current boundary of the material as one closed oriented triangle mesh: what is drawn, picked and embedded.
//
// Read off the gluing of the arrangement: a vertex is an orbit of corners under the gluing, so the two banks of an
// incision never share a vertex and every bank belongs to one cell copy. Vertices keep rest positions for ever.
#include <cstdint>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

enum class FaceKind : uint8_t { skin = 0, fixed = 1, free = 2, wall = 3 };

struct SurfaceView {
  // Per vertex.
  std::vector<Vec3> X_mm;  // rest position
  std::vector<int32_t>
      cell_copy;  // the cell copy that carries it (index into LatticeTopology::cells); filled by the lattice
  std::vector<int32_t> point;  // arrangement point id: banks of one cut share it

  // Per triangle, counter-clockwise seen from outside the material.
  std::vector<Tri> tri;
  std::vector<std::array<Eigen::Vector2f, 3>> uv;
  std::vector<FaceKind> kind;
  std::vector<int32_t> sided_face;  // 2 * face + side: names the same sided face from version to version
  std::vector<int32_t> component;   // of the closed sided surface
  std::vector<int32_t> origin;      // skin/fixed/free: index of the triangle of Body::surface; wall: cut number
};

}  // namespace limberg
