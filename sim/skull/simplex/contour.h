#pragma once
// Contours: closed cycles of neighbouring vertices, and closed curves across edges. Where they come from (picks,
// planes, regions of faces, rims of holes) and how holes are made from them.
#include <span>
#include <string>
#include <vector>

#include "sim/skull/simplex/operators.h"

namespace limberg::simplex {

/// Why there is no contour; empty contour then.
struct ContourResult {
  std::vector<int32_t> contour;
  std::string reason;  // empty: the contour is good
  explicit operator bool() const { return reason.empty(); }
};

/// Through picked vertices in order and back to the first: shortest paths along edges (ties go to the smaller vertex),
/// with spurs taken out. Refused when fewer than two different vertices are picked, a pick does not exist, two lie on
/// different parts, or the way crosses itself.
ContourResult contour_through(const Mesh& mesh, std::span<const int32_t> picks);

/// The border of a region of faces, with the region on its left. Refused when the border is not one simple cycle.
ContourResult contour_of_faces(const Mesh& mesh, std::span<const int32_t> faces);

/// Closed curves in which a plane crosses the surface, for t4_edges: each with the side of the normal on its left. A
/// vertex on the plane counts as on the side of the normal. Curves that reach an end face are left out and counted. All
/// curves may be cut one after the other: no edge is in two of them.
struct PlaneCurves {
  std::vector<std::vector<Crossing>> curve;  // in order of their smallest vertex
  int open = 0;
};
PlaneCurves curves_of_plane(const Mesh& mesh, const Vec3& point_mm, const Vec3& normal);

/// Keeps a contour: operators then leave its vertices alone. Refused (with the reason) when it is no simple cycle of
/// neighbours or meets another kept contour. Not part of deltas.
std::string keep_contour(Mesh& mesh, std::span<const int32_t> contour);
void release_contour(Mesh& mesh, size_t index);

/// Sets the zone of all vertices that can be reached from v without crossing the vertices of kept contours (which stay
/// as they are). Returns how many.
int32_t fill_zone(Mesh& mesh, int32_t v, uint16_t zone);

/// The end contours: holes and cut mouths with their rims, by smallest vertex.
struct EndContour {
  int32_t face = -1;
  FaceKind kind = FaceKind::hole;
  std::vector<int32_t> rim;  // surface on its right, as the walk of the end face gives it
};
std::vector<EndContour> end_contours(const Mesh& mesh);

/// Opens a hole where the region of faces is: t4 along its border, the piece removed, the mouth flagged as a hole.
/// OperatorResult::face[0] is the hole. Refused as t4 refuses, or with Answer::not_a_cycle when the border is no simple
/// cycle.
OperatorResult open_hole(Mesh& mesh, std::span<const int32_t> faces, Delta& delta);

}  // namespace limberg::simplex
