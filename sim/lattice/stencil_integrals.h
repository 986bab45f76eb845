#pragma once
// Integrals over boxes inside a cell: what stencils are summed from.
//
// A layer's part of a cell gives its matrix to K, exactly, and its law to material points: one at the centroid, or
// eight that have the volume, the centroid and the second moments of the part (of a box: its 2 x 2 x 2 Gauss points).
#include <vector>

#include "sim/fem/materials/catalogue.h"
#include "sim/lattice/fem_assembly.h"

namespace limberg {

/// A layer as stencils see it. The laws are indices into what becomes FemModel::laws.
struct LayerMatter {
  Material material;
  LayerResponse response;
  int32_t points_law = -1, whole_law = -1;  // -1: none
  bool directed() const {
    return response.directed || material.prestretch_along != 1 || material.prestretch_across != 1;
  }
};

/// Per layer; `laws` gets what they name. InputError as layer_response, with the layer's name.
std::vector<LayerMatter> layer_matter(const Body& body, std::vector<LawPtr>& laws);

/// Adds the box [lo, hi] (in cell units, 0..1 per axis) of one material to a stencil whose means are still sums.
void add_box(Stencil& s, const Vec3& cell_mm, const Vec3& lo, const Vec3& hi, const LayerMatter& m,
             const StretchFrame& frame);

/// Sums to means; rows of K to exact zero sums (rounding goes to the diagonal).
void finish_stencil(Stencil& s);

/// Integrals of products of gradients over each of kSplit^3 boxes of a cell, so that a cell of several layers is a sum
/// of tables: [box][xx, yy, zz, xy, yz, zx], the mixed ones symmetrised.
inline constexpr int kSplit = 4;
using GradientTable = std::array<Mat8, 6>;
std::vector<GradientTable> gradient_tables(const Vec3& cell_mm);

/// The unfinished stencil of a cell whose box b (x fastest) is of layer layer_of_box[b].
Stencil layered_stencil(const Vec3& cell_mm, const std::vector<GradientTable>& tables,
                        const std::vector<LayerMatter>& layers,
                        const std::array<int, kSplit * kSplit * kSplit>& layer_of_box, const StretchFrame& frame);

}  // namespace limberg
