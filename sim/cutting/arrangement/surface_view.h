#pragma once
// The current boundary of the material as one closed oriented triangle mesh: what is drawn, picked and embedded.
//
// Read off the gluing of the arrangement: a vertex is an orbit of corners under the gluing, so the two banks of an
// incision never share a vertex and every bank belongs to one cell copy. Vertices keep rest positions for ever.
//
// A view that follows another is made from it at the cost of what has changed: triangles
// and vertices that stay keep their numbers, new ones take the numbers of those that went,
// then further ones. So numbers tell of the history; the mesh, its triangles named by sided
// faces, is a function of the surface alone. Versions share what they have in common.
#include <cstdint>
#include <vector>

#include "sim/base/shared_array.h"
#include "sim/geometry/vec.h"

namespace limberg {

enum class FaceKind : uint8_t { skin = 0, fixed = 1, free = 2, wall = 3 };

struct SurfaceView {
  // Per vertex.
  SharedArray<Vec3> X_mm;  // rest position
  SharedArray<int32_t>
      cell_copy;  // the cell copy that carries it (index into LatticeTopology::cells); filled by the lattice
  SharedArray<int32_t> point;    // arrangement point id: banks of one cut share it
  SharedArray<int32_t> corners;  // how many corners of triangles it is

  // Per triangle, counter-clockwise seen from outside the material.
  SharedArray<Tri> tri;
  SharedArray<std::array<Eigen::Vector2f, 3>> uv;
  SharedArray<FaceKind> kind;
  SharedArray<int32_t> sided_face;  // 2 * face + side: names the same sided face from version to version
  SharedArray<int32_t> origin;      // skin/fixed/free: index of the triangle of Body::surface; wall: cut number
  SharedArray<uint8_t> rim;         // skin: bit k when a wall lies beyond the edge from corner k to the next

  SharedArray<int32_t> triangle_of;  // per sided face: its triangle, or -1
};

/// From one view to the next.
struct ViewChange {
  /// Everything was numbered anew; then `earlier`: per vertex its number before, -1 where it was found afresh.
  bool whole = false;
  std::vector<int32_t> earlier;
  /// Else: the vertices that are new or have other triangles around them (each is a corner of a triangle that is new),
  /// and the triangles that are new or have other corners or another rim; ascending. All others are what they were.
  std::vector<int32_t> vertices, triangles;
};

/// Per triangle: its component of the closed surface, numbered
/// from 0 in the order of their first triangles. O(triangles)
std::vector<int32_t> surface_components(const SurfaceView& view);

}  // namespace limberg
