#pragma once
// What is done to the triangles of a level set (graded_grid.h) before they are used: small pieces go, and so do the
// short edges that tetrahedra leave.
#include <functional>

#include "sim/imaging/fit/level_set.h"

namespace limberg {

/// Leaves the closed piece with the most triangles.
void keep_largest(std::vector<Vec3>& X_mm, std::vector<Tri>& tri);

/// An edge shorter than its place wants becomes its middle, put back on the surface, the shortest first, where the
/// surface stays a manifold and no triangle turns by more than 60 degrees, leaves the surface by more than .12 of the
/// wanted edge or grows longer than twice what is wanted.
void thin_edges(std::vector<Vec3>& X_mm, std::vector<Tri>& tri, const LevelSet& set,
                const std::function<double(const Vec3&)>& edge_mm);

}  // namespace limberg
