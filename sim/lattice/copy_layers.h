#pragma once
// Which layers the copies of a cell hold that a cut has divided.
//
// A cut that runs between skin and fat leaves a copy of fat above which there is none, and one of skin. The copies'
// volumes are exact (cells.h); what each holds of the layers is found on kColumns^2 lines through the cell, along the
// axis that is nearest to the way down from the skin. On a line the faces that it meets part the classes, exactly, and
// the layers' borders lie where the depth, linear in the cell, says so. A line that meets no face belongs to the class
// of the nearest edge of the cell. So a wall of any shape counts, and one along the lines (an upright incision) leaves
// every class the mixture of its cell.
//
// As long as nothing was taken out of the cell, the classes together hold what the cell does: the error of the lines
// cancels. Shares are rounded to kShareSteps, so that there are few stencils; a copy whose shares are those of its cell
// within kSameShare, less than the lines tell apart beside a wall that is nearly upright, takes the cell's stencil.
#include <span>
#include <vector>

#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/layered_cell.h"
#include "sim/lattice/material_surface.h"

namespace limberg {

inline constexpr int kColumns = 8;
inline constexpr int kShareSteps = 256;
inline constexpr double kSameShare = 0.02;

/// Per class of a cell and layer, the volume in mm^3 that the lines find: [class * (end_mm.size() + 1) + layer].
/// `low_half`, `size_half`: the cell's low corner and edges in half-units. `end_mm`: as CellCutter's.
std::vector<double> layers_of_classes(const CellComponents& cell, const MaterialSurface& surface, const Vec3& low_half,
                                      const Vec3& size_half, const CellDepth& depth, std::span<const double> end_mm);

/// The stencil of a copy, of the class `cls` of its cell. `whole`: that of the undivided cell.
int32_t stencil_of_copy(const StencilTable& table, const MaterialSurface& surface, const LatticeTopology& topology,
                        int32_t cell, int cls, int32_t whole);

}  // namespace limberg
