#pragma once
// Osteotomies: what the saw does to a bone, both tables of it.
//
// A cut is a surface through the bone: a plane, or a closed contour on the bone swept along the inward normals.
// Where it crosses the edges of the mesh the bone is divided (t4_edges): one curve for each time that the surface
// meets the bone, exact on every edge. What is bone between the curves becomes wall (wall.h), on both sides the same
// polygons. So the fragment and what is left are closed and watertight, and fit each other without gap or overlap.
//
//   contour, table of bone no thicker than deepest_mm    two curves: the drawn one and that on the other table
//   contour, solid bone, or the contour goes around it   one curve; the wall spans it
//   plane                                                every closed curve, in sets: an outer one and what lies within
//   fan of planes (corner_blade.h)                       the same; where the wall of solid bone crosses a fold it folds
//
// Volumes: the walls of both sides cancel. What may differ is the surface that the curve
// crosses: a face is a fan about a lifted centre, and its halves are fans about their own. So
// |sum of parts - whole| is at most the sum, over the faces that are crossed, of their area
// times the sum of the largest heights of the fans above and below the plane of the face.
#include <string>
#include <vector>

#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/edit.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::bone {

struct Osteotomy {
  enum class Kind { contour, plane, fan };
  Kind kind = Kind::contour;
  /// contour: places on the bone at rest, in order, closed. Near together: a drawn path, as it is. Further apart than
  /// kPickStep_mm: picked points, joined straight on along the surface (in the plane of the two points and the normal).
  std::vector<Vec3> path_mm;
  Vec3 point_mm = Vec3::Zero(), normal = Vec3::UnitZ();  // plane
  int32_t fragment = -1;                                 // -1: the one nearest to the first place
  bool must_divide = true;                               // refused when the bone would stay in one piece
  double radius_mm = 0;    // plane: > 0 cuts only where the curve comes within this distance of point_mm
  double deepest_mm = 25;  // contour: bone thicker than this is solid
  // fan: planes that meet in point_mm, each between two of these directions and radius_mm long (CornerBlade).
  std::vector<Vec3> ray;
};

/// Two places of a path further apart than this are picks, and a drawn path is open when its ends are.
inline constexpr double kPickStep_mm = 5;
/// A fragment smaller than this is refused: the edges of the meshes are 2 to 4 mm long.
inline constexpr double kSmallest_mm3 = 20;

/// What is told of a cut that was allowed to free nothing, and did not.
inline constexpr const char* kHangsTogether = "the bone still hangs together elsewhere";

/// What a cut did. A refused one (reason not empty) has changed nothing.
struct Cut {
  std::string reason;
  int curves = 0;  // along which the bone was divided
  std::vector<int32_t> wall_left,
      wall_right;  // faces of the new walls, on the left (normal's, inner) side and on the other
  explicit operator bool() const { return reason.empty(); }
};

/// Cuts the component of vertex `inside`. Appends to `delta`.
Cut cut_bone(simplex::Mesh& mesh, int32_t inside, const Osteotomy& what, simplex::Delta& delta);

}  // namespace limberg::bone
