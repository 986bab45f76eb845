#pragma once
// Meshes to begin with: spheres, tori, cylinders and planes of hexagons (a sphere needs twelve pentagons).
//
// Vertices lie exactly on the surface asked for. All throw InputError when a size is not positive and finite or a count
// is too small or too large (at most 20 million vertices).
#include "sim/skull/simplex/mesh.h"

namespace limberg::simplex {

/// Dual of an icosahedron whose triangles are divided in four `levels` times: 20 * 4^levels vertices.
Mesh make_sphere(const Vec3& centre_mm, double radius_mm, int levels);

/// Dual of the convex hull of `faces` points spread along a spiral at equal steps of height (Fibonacci points):
/// 2 faces - 4 vertices, so 1002 faces give the 2000 vertices of the paper's sphere. 12 <= faces <= 20000. O(faces^2).
Mesh make_sphere_of_faces(const Vec3& centre_mm, double radius_mm, int faces);

/// Torus about z: 2 * around * across vertices, around >= 4 steps along the great circle (even: rows are shifted by
/// half a step every other one), across >= 4 along the small one.
Mesh make_torus(double great_radius_mm, double small_radius_mm, int around, int across);

/// Open cylinder about z, 0 <= z <= length, from rows of regular hexagons: `around` >= 4 of them, as many rows as make
/// them most nearly regular. Two end contours.
Mesh make_cylinder(double radius_mm, double length_mm, int around);

/// Rectangle 0..size_x, 0..size_y in z = 0, normal up, of nearly
/// regular hexagons with edges of about edge_mm. One end contour.
Mesh make_plane(double size_x_mm, double size_y_mm, double edge_mm);

}  // namespace limberg::simplex
