#pragma once
// Integrals over parts of a cell: what stencils are summed from.
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

/// Per layer, then per region; `laws` gets what they name. InputError as layer_response, with its name.
std::vector<LayerMatter> layer_matter(const Body& body, std::vector<LawPtr>& laws);

/// Integrals (mm^3) over a part of a cell of x^i y^j z^k, 0 <= i, j, k <= 2, at 9 k + 3 j + i; x, y, z in cell units.
/// Products of gradients of trilinear functions are such polynomials.
struct CellMoments {
  std::array<double, 27> of{};
  double volume_mm3() const { return of[0]; }
  Vec3 centre() const { return Vec3(of[1], of[3], of[9]) / of[0]; }  // cell units
  Mat3 second() const;                                               // about the centre, per volume, cell units
  void add(const CellMoments& o, double factor = 1);
  /// `edge`, in cell units: a cube of that edge about it.
  void add_point(const Vec3& at, double volume_mm3, double edge = 0);
};

/// Adds the box [lo, hi] (in cell units, 0..1 per axis) of one material to a stencil whose means are still sums.
void add_box(Stencil& s, const Vec3& cell_mm, const Vec3& lo, const Vec3& hi, const LayerMatter& m,
             const StretchFrame& frame);

/// Sums to means; rows of K to exact zero sums (rounding goes to the diagonal).
void finish_stencil(Stencil& s);

/// The same for a part of the cell of any shape, from its moments.
void add_moments(Stencil& s, const Vec3& cell_mm, const CellMoments& of, const LayerMatter& m,
                 const StretchFrame& frame);

}  // namespace limberg
