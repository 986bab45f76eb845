#pragma once
// Linear tetrahedra: on the body-centred lattice of a box, and of imported meshes.
//
// Body-centred: nodes at the corners and the centre of every cell; a tetrahedron has one edge of a square between two
// cells and the two cells' centres (four for each square); at the surface the pyramid on a square is halved. All inner
// tetrahedra are congruent, the usual choice for embedded tissue (Molino et al. 2003). They are here for comparison:
// near incompressibility they lock, which `bench accuracy` and `bench verification` show in figures.
#include <span>

#include "sim/fem/elements/shaped_cells.h"
#include "sim/fem/model/box_model.h"

namespace limberg {

/// The box of `spec` (no hole), upper and lower half with their own constants, stable neo-Hookean as box_model's.
FemModel bcc_box_model(const BoxSpec& spec);

/// A mesh from elsewhere. InputError names the tetrahedron that is flat or names a vertex that does not exist.
FemModel tet_mesh_model(std::span<const Vec3> vertices_mm, std::span<const std::array<int32_t, 4>> tets,
                        double young_kPa, double poisson, double density_kg_mm3 = 1e-6);

/// The point of a model of tetrahedra nearest to X by barycentric coordinates.
EmbeddedPoint embed_in_tets(const FemModel& model, const Vec3& X_mm);

}  // namespace limberg
