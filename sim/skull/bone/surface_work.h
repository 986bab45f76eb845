#pragma once
// Work on the surface of a bone that cuts nothing: its mesh made finer or coarser at a place, a region smoothed, the
// surface pushed away by a ball. As the craniofacial paper has them for a hand on a simplex mesh.
//
//   split_face     T2: the face at a place becomes two, by a new edge across its longest direction
//   merge_faces    T1: the edge nearest to a place is deleted with both ends; the faces on its sides become one
//   smooth         the region within radius_mm along edges moves by the force that evens curvature (seam.h); the volume
//                  of the bone is kept
//   push           a ball of radius_mm goes from one place to another; what lies nearer to its way is pushed out of it
//                  (motion.h: Repulsor), and spreads along the surface meanwhile
//
// Walls of cuts, rims and locked vertices hold still.
#include <string>

#include "sim/base/workers.h"
#include "sim/skull/simplex/edit.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::bone {

struct SurfaceWork {
  enum class Kind { split_face, merge_faces, smooth, push } kind = Kind::smooth;
  Vec3 at_mm = Vec3::Zero(), to_mm = Vec3::Zero();  // on the bone at rest; to_mm: where the ball ends
  double radius_mm = 0;
};

/// A place farther than this from the bone is refused; a ball may begin as far off as its own radius and this.
inline constexpr double kWorkFarthest_mm = 10;

struct WorkedSurface {
  std::string reason;  // not empty: it cannot be done, and nothing has changed
  std::string words;   // what it did
};

/// On the component of vertex `inside`. What it did is appended to `delta`.
WorkedSurface work_surface(simplex::Mesh& mesh, int32_t inside, const SurfaceWork& work, Workers& workers,
                           simplex::Delta& delta);

}  // namespace limberg::bone
