#pragma once
// Integrals over boxes inside a cell: what stencils are summed from.
#include <vector>

#include "sim/lattice/fem_assembly.h"

namespace limberg {

/// Adds the box [lo, hi] (in cell units, 0..1 per axis) of one material to a stencil whose means are still sums.
void add_box(Stencil& s, const Vec3& cell_mm, const Vec3& lo, const Vec3& hi, const Material& m,
             const StretchFrame& frame);

/// Sums to means; rows of K to exact zero sums (rounding goes to the diagonal).
void finish_stencil(Stencil& s);

/// Integrals of products of gradients over each of kSplit^3 boxes of a cell, so that a cell of several layers is a sum
/// of tables: [box][xx, yy, zz, xy, yz, zx], the mixed ones symmetrised.
inline constexpr int kSplit = 4;
using GradientTable = std::array<Mat8, 6>;
std::vector<GradientTable> gradient_tables(const Vec3& cell_mm);

/// The unfinished stencil of a cell whose box b (x fastest) is of layer layer_of_box[b].
Stencil layered_stencil(const Vec3& cell_mm, const std::vector<GradientTable>& tables, const std::vector<Layer>& layers,
                        const std::array<int, kSplit * kSplit * kSplit>& layer_of_box, const StretchFrame& frame);

}  // namespace limberg
