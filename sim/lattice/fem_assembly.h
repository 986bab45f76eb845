#pragma once
// From body and lattice to the elements of fem_model.h.
//
// A stencil holds what is constant in one kind of full cell: integrals over its layers, with the prestretch in the frame
// of the skin. Block: layers are flat, so two Gauss points in the plane and two in depth per layer piece integrate
// trilinear products exactly, however thin a layer is; all cells of a row share one stencil. Other bodies: midpoints of
// 4 x 4 x 4 sub-cells with the depth and frame of Skin; equal stencils are merged.
//
// A cell copy takes its stencil times max(fraction, 1e-2); a fraction above 0.998 counts as 1, so that the micrometres by
// which lattice planes lie outside a block do not load it. Masses take the exact fraction.
#include <memory>

#include "sim/fem/fem_model.h"
#include "sim/geometry/skin.h"
#include "sim/lattice/topology.h"

namespace limberg {

/// Stencils of a body on a grid; built once, reused for every version of the topology.
class StencilTable {
 public:
  StencilTable(const Skin& skin, const LatticeGrid& grid);
  const std::vector<Stencil>& stencils() const { return stencils_; }
  int32_t of_cell(int32_t cell) const { return of_cell_[size_t(cell)]; }  // -1: cell wholly outside the body

  /// Fixed nodes of the lattice, per node: block: bit 2 axis + (0 low, 1 high) for planes that hold a fixed side; other
  /// bodies: 0x80 where the node lies outside or within 0.1 cell of the surface and the nearest triangle is fixed.
  const std::vector<uint8_t>& fixed_candidates() const { return fixed_; }

 private:
  std::vector<Stencil> stencils_;
  std::vector<int32_t> of_cell_;
  std::vector<uint8_t> fixed_;
};

/// A node copy is fixed where its lattice node is a candidate and one of its cell copies holds a fixed face there, so a
/// flap raised from its bed does not stay pinned to the bed's nodes.
std::shared_ptr<const FemModel> assemble_fem(const StencilTable& table, const LatticeTopology& topology);

/// The stencil of a homogeneous box of material, by the same quadrature (tests, other assemblies).
Stencil homogeneous_stencil(const Vec3& cell_mm, const Material& material, const Vec3& along, const Vec3& across);

}  // namespace limberg
