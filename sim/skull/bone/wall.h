#pragma once
// Walls: the cut surface between the mouths of a bone.
//
// Two mouths (faces X and Y of the same side of a cut, one on each table) are joined by `rungs`: edges from an edge of
// X to an edge of Y. Both mouths go, and between each two rungs lies a face of kind `wall`. The rings stay as they are,
// as creases. Change of (V, E, F, chi) for k rungs: (+2k, +3k, k - 2, -2): that is t3, then k times t2. A single mouth
// (solid bone) becomes one wall face: (0, 0, 0, 0).
//
// The mouths of the two sides have the same places in opposite order. Everything is planned once for both, so their
// walls are made of the same polygons, bit for bit.
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "sim/skull/simplex/edit.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::bone {

/// A mouth or wall face on both sides of a cut. right[j] and left[j] lie at the same place; `right` runs as the face on
/// the right does, `left` against its face.
struct Facing {
  int32_t face_left = -1, face_right = -1;
  std::vector<int32_t> left, right;
};

/// A rung between edge a of one ring (a -> a + 1 in the order of `right`) and edge b of another, and where it ends.
struct Rung {
  int32_t a = 0, b = 0;
  Vec3 a_mm, b_mm;
};

/// Rungs between two rings, x in order and y against its order: one for each edge of the shorter ring, each to another
/// edge of the longer one, in order, with the least sum of squares of their lengths. In order of a.
std::vector<Rung> plan_rungs(const std::vector<Vec3>& x_mm, const std::vector<Vec3>& y_mm);

/// Joins x and y on both sides by rungs (in order of a, at most one on an edge,
/// three at least). Answers with the reason when it cannot be done; what `delta`
/// then holds has to be undone. `walls`: the new faces, in order of the rungs.
std::string join_by_walls(simplex::Mesh& mesh, const Facing& x, const Facing& y, const std::vector<Rung>& rungs,
                          simplex::Delta& delta, std::vector<Facing>& walls);

/// Turns the mouths of a cut into walls.
void close_by_walls(simplex::Mesh& mesh, const Facing& mouth, simplex::Delta& delta);

/// Divides a wall face on both sides by an edge from edge a of its ring (a -> a + 1 in the order of `right`) to edge b,
/// a < b, ending there at those places. The two new pairs: what lies after a up to b, and the rest. Change of (V, E, F,
/// chi) of a side: (2, 3, 1, 0), that is t2.
std::array<Facing, 2> divide_wall(simplex::Mesh& mesh, const Facing& wall, const Rung& across, simplex::Delta& delta);

}  // namespace limberg::bone
