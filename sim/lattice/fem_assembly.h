#pragma once
// From body and lattice to the elements of fem_model.h.
//
// A stencil holds what is constant in one kind of full cell: integrals over its layers, with the prestretch in the
// frame of the skin. The material is constant in boxes, and in each box 2 x 2 x 2 Gauss points integrate products of
// trilinear gradients exactly.
//   Block (flat skin on top): the boxes are the layers themselves, cut by the cell, however thin they are; all cells of
//   a row share one stencil. Other bodies: 4 x 4 x 4 boxes where a layer boundary may cross the cell (material by the
//   depth of the box's middle, interpolated from the cell's corners), else one; frame at the cell's centre. Cells that
//   lie wholly in one layer without prestretch share its stencil.
//
// A cell copy takes its stencil times max(fraction, kLeastFraction); a fraction above 0.998 counts as 1,
// so that the micrometres by which lattice planes lie outside a block do not load it. Masses
// take the exact fraction. Parts of divided cells have stencils of their own size
// (Stencil::level), made in the same way when they are first asked for; where planes must lie
// further out so that cells can be divided (grid_fit.h), a little less than full counts as full.
// FemModel::cells[i] is LatticeTopology::cells[i], FemModel node i is LatticeTopology::nodes[i].
#include <array>
#include <map>
#include <memory>

#include "sim/body/skin.h"
#include "sim/fem/model/fem_model.h"
#include "sim/lattice/topology.h"

namespace limberg {

struct LayerMatter;

/// For conditioning: a sliver's nodes stay solvable in float. Tissue of less than this share of a cell is not told from
/// none.
inline constexpr double kLeastFraction = 1e-2;

/// Stencils of a body on a grid; built once, reused for every version of the topology.
class StencilTable {
 public:
  /// Throws InputError when the body has no layer or a layer with impossible constants.
  /// The skin must outlive the table when cells will be divided.
  StencilTable(const Skin& skin, const LatticeGrid& grid);
  ~StencilTable();
  const SharedArray<Stencil>& stencils() const { return stencils_; }
  const std::vector<LawPtr>& laws() const { return laws_; }               // that points of the stencils name
  int32_t of_cell(int32_t cell) const { return of_cell_[size_t(cell)]; }  // -1: the body is nowhere in the cell
  /// The same for a cell of any level; may add to stencils(), so one thread at a time.
  int32_t of_place(const CellPlace& place) const;

  /// Where a lattice node, or a corner of a part, may be held; in eighths
  /// of a cell. Block: bit 2 axis + (0 low, 1 high) per outermost plane
  /// whose side is fixed. Other bodies, when the surface triangle nearest
  /// to it is fixed: kNearFixed within 0.1 cell, kFarFixed beyond.
  static constexpr uint8_t kNearFixed = 0x80, kFarFixed = 0x40;
  uint8_t fixed_candidate(Int3 at) const;

 private:
  void fill_block(const Body& body, const LatticeGrid& grid);
  void fill_general(const Skin& skin, const LatticeGrid& grid);
  int32_t intern(const Stencil& s) const;
  Stencil block_row(const LatticeGrid& grid, int32_t z) const;
  Stencil general_part(const LatticeGrid& grid, Int3 at) const;
  std::vector<LayerMatter> matter_;  // per layer
  std::vector<LawPtr> laws_;
  mutable SharedArray<Stencil> stencils_;
  std::vector<int32_t> of_cell_;
  std::vector<uint8_t> fixed_;
  // For parts of cells.
  const Skin* skin_;
  LatticeGrid grid_;
  bool is_block_ = false;
  uint8_t fixed_sides_ = 0;                                    // of a block
  mutable std::map<std::array<int32_t, 4>, int32_t> of_part_;  // level and place (of a block: z alone)
  mutable std::map<std::array<int32_t, 3>, uint8_t> fixed_part_;
};

/// A node copy is fixed where its lattice node is a candidate (kFarFixed: outside the
/// material) and one of its cell copies holds a fixed face of that side: a flap raised
/// from its bed does not stay pinned to the bed's nodes. `before`: the previous version of
/// the topology and its model; copies that were there keep what depends on their place.
struct EarlierModel {
  const LatticeTopology& topology;
  const FemModel& model;
};
std::shared_ptr<const FemModel> assemble_fem(const StencilTable& table, const LatticeTopology& topology,
                                             const EarlierModel* before = nullptr);

/// The axes of prestretch of a flat piece of skin: `along` and `across` orthonormal, normal = along x across.
struct StretchFrame {
  Vec3 along = Vec3::UnitX(), across = Vec3::UnitY(), normal = Vec3::UnitZ();
};

/// F0 F0^T of the layer's prestretch in that frame; det F0 = 1.
Mat3 prestretch_tensor(const Material& material, const StretchFrame& frame);

/// The stencil of a box of one material; its points name law 0, that of layer_response(material).
Stencil homogeneous_stencil(const Vec3& cell_mm, const Material& material, const StretchFrame& frame = {});

}  // namespace limberg
