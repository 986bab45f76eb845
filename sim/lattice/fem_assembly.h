#pragma once
// From body and lattice to the elements of fem_model.h.
//
// A stencil holds what is constant in one kind of cell: integrals over its layers, with the prestretch in the frame
// of the skin, and nothing of what lies outside the body.
//   Block (flat skin on top): boxes that are the layers themselves, cut by the cell, however thin they are, with 2 x 2
//   x 2 Gauss points in each; all cells of a row share one stencil. Other bodies: where a layer's border or the skin
//   may cross the cell, or its corners are held, each layer's moments in it (cut_cells.h, held_cells.h); else one box;
//   frame at the cell's centre. What regions take of a cell (region_cells.h) is theirs in both.
//   Cells of one layer without prestretch share its stencil, cut by the surface or not.
//
// A copy whose corners are not held as its stencil has it (a flap raised from a bed that is no plane of the lattice)
// takes one that is made for those which are.
//
// A cell copy takes its stencil times its volume over that for which the stencil stands (body_mm3), the whole cell or
// the body's part of it, with at least kLeastFraction of the cell; a fraction above 0.998 of a whole cell counts as 1,
// so that the micrometres by which lattice planes lie outside a block do not load it. Copies of one cell whose wall
// parts its layers have stencils of their own mixtures (copy_layers.h). Masses take the exact fraction and the cell's
// mean density. Parts of divided cells have
// stencils of their own size (Stencil::level), made in the same way when they are first asked for; where planes must
// lie further out so that cells can be divided (grid_fit.h), a little less than full counts as full.
// FemModel::cells[i] is LatticeTopology::cells[i], FemModel node i is LatticeTopology::nodes[i].
#include <array>
#include <map>
#include <memory>

#include "sim/body/skin.h"
#include "sim/fem/model/fem_model.h"
#include "sim/lattice/topology.h"

namespace limberg {

struct LayerMatter;
struct HeldCorners;
struct StretchFrame;
struct LayeredCell;
class CellCutter;
class RegionCells;
/// A cell is looked at on the corners of kSplit^3 boxes, x fastest (cut_cells.h).
inline constexpr int kSplit = 4, kSamples = (kSplit + 1) * (kSplit + 1) * (kSplit + 1);
using CellSamples = std::array<Skin::Place, kSamples>;

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
  const std::vector<LawPtr>& laws() const { return laws_; }  // that points of the stencils name
  /// How active each region of the body is, 0 to 1; of one whose law takes no "activation" 0.
  const std::vector<double>& activation() const { return activation_; }
  /// laws() are then those of such activity. Nothing else changes: what is active pulls along its fibres only.
  void activate(const std::vector<double>& activation);
  int32_t of_cell(int32_t cell) const { return of_cell_[size_t(cell)]; }  // -1: the body is nowhere in the cell
  /// The same for a cell of any level; may add to stencils(), so one thread at a time.
  int32_t of_place(const CellPlace& place) const;
  /// Makes what of_place() of these will be asked for, on all workers: the same stencils with the same numbers.
  void make_ready(std::span<const CellPlace> places, Workers& workers) const;
  /// The corners (bits) that a stencil takes as held: its functions vanish at the held surface, and those corners have
  /// next to no stiffness against each other (held_cells.h).
  uint8_t held_corners(int32_t stencil) const { return held_of_[size_t(stencil)]; }
  bool any_held_corners() const { return !held_surface_.empty(); }
  /// As of_place(), of a copy of which these corners alone are held: a flap that a cut has raised from its bed.
  int32_t of_place(const CellPlace& place, uint8_t held) const;

  /// The volume of tissue that a stencil stands for: the body's in a cell that it does not fill, else the cell's.
  double body_mm3(int32_t stencil) const { return body_mm3_[size_t(stencil)]; }

  /// The depth at which each layer of the body ends but for the last, ascending.
  const std::vector<double>& layer_ends() const { return layer_ends_; }
  /// What the stencil of a whole cell was made from, if that is several layers whose corners nothing holds; else null.
  const LayeredCell* layered(int32_t stencil) const { return layered_[size_t(stencil)].get(); }
  /// The stencil of a layered cell with other shares of the layers, in steps (copy_layers.h); stands for the same
  /// volume. May add to stencils(), so one thread at a time.
  int32_t mixed(int32_t stencil, const std::vector<int32_t>& steps) const;

  /// Where a lattice node, or a corner of a part, may be held; in eighths
  /// of a cell. Block: bit 2 axis + (0 low, 1 high) per outermost plane
  /// whose side is fixed. Other bodies, when the surface triangle nearest
  /// to it is fixed: kNearFixed within 0.1 cell, kFarFixed beyond.
  static constexpr uint8_t kNearFixed = 0x80, kFarFixed = 0x40;
  uint8_t fixed_candidate(Int3 at) const;
  /// Whether a side of a block, 2 axis + (0 low, 1 high), holds along its axis only (Body::sliding_sides).
  bool slides(int side) const { return sliding_sides_ >> side & 1; }

 private:
  void fill_block(const Body& body, const LatticeGrid& grid);
  class Sampler;
  void fill_general(const Skin& skin, const LatticeGrid& grid);
  void find_held(const Skin& skin, const LatticeGrid& grid);
  HeldCorners held_corners(Int3 cell);
  HeldCorners held_part(const LatticeGrid& grid, Int3 at, int level, uint8_t of = 0xff) const;
  struct Made;  // a stencil, the volume that it stands for, and what it was made from
  Made cut_cell(const CellCutter& cutter, const CellSamples& samples, const HeldCorners& held, const Vec3& centre_mm,
                const Skin::Place& at_centre) const;
  Made divided_cell(const CellCutter& cutter, const CellSamples& samples, const HeldCorners& held,
                    const Vec3& centre_mm, const Skin::Place& at_centre, const StretchFrame& frame) const;
  bool unlike_its_row(const CellPlace& place) const;
  struct Part {                  // of a divided cell
    std::array<int32_t, 4> key;  // level and place (of a row of a block: z alone)
    bool of_row = false;
  };
  Part part_at(const CellPlace& place) const;
  Made make_part(const CellPlace& place, bool of_row) const;
  Skin::Place place_in_block(const Vec3& X_mm, Skin::Near& near) const;
  Made block_cell(const LatticeGrid& grid, Int3 at) const;
  int32_t add(Made made) const;
  int32_t intern(Made made) const;
  Made block_row(const LatticeGrid& grid, int32_t z) const;
  Made general_part(const LatticeGrid& grid, Int3 at, int level, uint8_t held = 0xff) const;
  std::vector<LayerMatter> matter_;  // per layer, then per region
  std::vector<LawPtr> laws_;
  std::vector<double> activation_;
  mutable SharedArray<Stencil> stencils_;
  std::vector<double> layer_ends_;
  mutable std::vector<double> body_mm3_;  // per stencil
  mutable std::vector<uint8_t> held_of_;
  mutable std::vector<std::shared_ptr<LayeredCell>> layered_;
  mutable std::map<uint64_t, std::vector<int32_t>> alike_;  // stencils by a hash of some of their numbers
  std::vector<int32_t> of_cell_;
  std::vector<uint8_t> fixed_;
  SidedPatch held_surface_;         // of a body that is no block; empty: nothing holds it
  std::vector<double> held_depth_;  // per node: how far above it; NaN: not asked for yet
  // For parts of cells.
  const Skin* skin_;
  std::unique_ptr<RegionCells> regions_;    // null: the body has none
  mutable std::vector<double> region_mm3_;  // what each was found to take of the cells looked at
  LatticeGrid grid_;
  bool is_block_ = false;
  double top_mm_ = 0;                                                      // of a block
  uint8_t fixed_sides_ = 0, sliding_sides_ = 0;                            // of a block
  mutable std::map<std::array<int32_t, 4>, int32_t> of_part_;              // Part::key
  mutable std::map<std::array<int32_t, 4>, std::unique_ptr<Made>> ready_;  // not asked for yet
  mutable std::map<std::array<int32_t, 5>, int32_t> of_held_;              // and corners
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
/// Stencils of the parts of cells that are new since `before` (null: of all), made on all workers; assemble_fem finds
/// them.
void make_parts_ready(const StencilTable& table, const LatticeTopology& topology, const LatticeTopology* before,
                      Workers& workers);
/// `surface`: what the topology was made from; without it copies have the mixture of layers of their cell.
std::shared_ptr<const FemModel> assemble_fem(const StencilTable& table, const LatticeTopology& topology,
                                             const EarlierModel* before = nullptr,
                                             const MaterialSurface* surface = nullptr);

/// The axes of prestretch of a flat piece of skin: `along` and `across` orthonormal, normal = along x across.
struct StretchFrame {
  Vec3 along = Vec3::UnitX(), across = Vec3::UnitY(), normal = Vec3::UnitZ();
};

/// F0 F0^T of the layer's prestretch in that frame; det F0 = 1.
Mat3 prestretch_tensor(const Material& material, const StretchFrame& frame);

/// The stencil of a box of one material; its points name law 0, that of layer_response(material).
Stencil homogeneous_stencil(const Vec3& cell_mm, const Material& material, const StretchFrame& frame = {});

}  // namespace limberg
