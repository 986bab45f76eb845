#pragma once
// From triangles to a simplex mesh and back.
//
// Duality exchanges triangles with vertices and vertices with faces. It is one of topology only:
// where the dual vertices lie is a choice. Centroids shrink the shape, and the place nearest to
// the tangent planes at the corners (least squares) inflates it by as much; the default puts
// each vertex half way between. The fan of a face is lifted the same way; at the crease between
// a wall and the surface each of them has its own tangent plane, so that neither bulges.
//
// Every border loop of an open surface becomes one face of kind `hole`: the loop is closed by a cone
// whose tip is the hole, so each border edge gives one more vertex, at the middle of that edge.
#include <vector>

#include "sim/geometry/vec.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::simplex {

enum class DualPlacement { tangent_planes, centroid };

/// X_mm, tri: an oriented manifold surface, open or closed, in any number of parts. Vertices that no triangle uses are
/// ignored. Vertex t of the result is triangle t; then follow the border edges, loop by loop (by smallest vertex).
/// `hole_size` (may be null) receives the vertices of each hole. Throws InputError: an index out of range, a triangle
/// with two equal corners, an edge of three triangles or of two that disagree in orientation, a vertex where two fans
/// touch, a triangulation with double edges (its dual has faces that share two edges), a vertex that is not finite.
Mesh from_triangles(const std::vector<Vec3>& X_mm, const std::vector<Tri>& tri,
                    DualPlacement placement = DualPlacement::tangent_planes);

/// Triangles to draw, pick or export: every face that is not an end, as a fan about its centre.
struct FanTriangles {
  std::vector<Vec3> X_mm;     // the vertices of the mesh (slot by slot), then the face centres
  std::vector<Tri> tri;       // counter-clockwise seen from outside: centre, v, next of v
  std::vector<int32_t> face;  // per triangle: which face of the mesh
};
FanTriangles fan_triangles(const Mesh& mesh);

/// The dual triangulation: one vertex per face that is not an end (at its fan centre), one triangle per vertex whose
/// three faces are all drawn. `face_of` (may be null): which face each vertex is.
struct DualTriangles {
  std::vector<Vec3> X_mm;
  std::vector<Tri> tri;
  std::vector<int32_t> face_of, vertex_of;  // per X: the face; per triangle: the vertex of the mesh
};
DualTriangles dual_triangles(const Mesh& mesh);

/// Where the fan of a face has its centre.
Vec3 face_centre(const Mesh& mesh, int32_t face);
/// Sum of its fan's areas, and their mean normal times that area (mm^2).
struct FaceArea {
  double area_mm2 = 0;
  Vec3 vector_mm2 = Vec3::Zero();
};
FaceArea face_area(const Mesh& mesh, int32_t face);

/// Of the fans: area of the surface, volume inside (meaningful
/// when closed; end faces are closed by a flat fan), mm^2, mm^3.
struct Extent {
  double area_mm2 = 0, volume_mm3 = 0;
};
Extent extent(const Mesh& mesh);

}  // namespace limberg::simplex
