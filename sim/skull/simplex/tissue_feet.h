#pragma once
// Where the columns of a tissue stand so that every tetrahedron in them is sound: well shaped, and thick enough.
//
// A column stands where the normal of the face, inwards, meets bone, or else at the nearest place. Over a whole face
// some columns then cross or lie flat: over the mouth, the orbits, the nostrils, the ears. Of these alone the feet go
// elsewhere, one after the other, each to the best of a few places by the worst of its prisms:
//
//   on bone     below where the columns around it stand in the mean
//   hovering    above the bone, along its own way, that mean, or the normal evened out over the patch, as far as the
//               bone there or nearer
//
// until all are sound or nothing gets better. A prism that is still below the floor is named, and so are columns of
// which the bone lies nearer to the skin than the floor, or outside of it: their vertices are to be left out.
#include <vector>

#include "sim/geometry/bvh.h"
#include "sim/skull/simplex/tissue.h"

namespace limberg::simplex {

/// The dual triangulation of a region of a face: nodes are the centres of its faces.
struct TissuePatch {
  std::vector<Vec3> top, normal;           // per node
  std::vector<Tri> tri;                    // per vertex of the region, counter-clockwise from outside
  std::vector<std::vector<int32_t>> near;  // nodes next to a node
  std::vector<std::array<int32_t, 2>> border;
};

/// The tetrahedra of one layer of a prism, nodes numbered 0 to 2 below and 3 to 5 above in the order of `t`: every
/// quad's diagonal starts at its lower node, so neighbours agree. Not yet turned to a positive volume.
std::array<std::array<int32_t, 4>, 3> prism_tets(const Tri& t);

struct TissueFeet {
  std::vector<Vec3> bottom;      // per node
  std::vector<uint8_t> hovers;   // it does not stand on bone
  std::vector<int32_t> unsound;  // triangles whose prism is below the floor; of several that touch the worst
};
/// Nodes farther than `farthest_mm` from bone make their triangles unsound.
TissueFeet sound_feet(const TissuePatch& patch, const Bvh& bone, double farthest_mm, int layers,
                      const TissueFloor& floor);

}  // namespace limberg::simplex
