#pragma once
// The surface of a level set through tetrahedra that are small only where small ones are wanted.
//
// Cubes of 16 mm, each cut in six tetrahedra about a diagonal, are bisected by Maubach's rule (1995: an edge of a
// tetrahedron is told by its generation alone, and neighbours agree on it) where the surface may pass and they are
// larger than wanted; then wherever an edge was halved, until no tetrahedron has a halved edge. The triangles of all
// tetrahedra fit, so the surface is a manifold, as that of the even grid (level_set.h).
#include <functional>

#include "sim/imaging/fit/level_set.h"

namespace limberg {

/// `cell_mm`: the wanted side of a cube by place, above 0; down to 16 / 2^6 mm. Throws InputError as march does.
void march_graded(const LevelSet& surface, const std::function<double(const Vec3&)>& cell_mm, Workers& workers,
                  std::vector<Vec3>& X_mm, std::vector<Tri>& tri, int64_t* evaluations = nullptr);

}  // namespace limberg
