#pragma once
// The parts that topology.cpp is put together from.
#include "sim/base/number_set.h"
#include "sim/lattice/cell_builder.h"
#include "sim/lattice/topology.h"

namespace limberg {

inline constexpr int kLowToHigh[3] = {1, 2, 4};  // by axis: what a corner's number gains across the cell

/// Which lattice nodes lie in the material: every lattice line along x is walked through all that it hits. Throws
/// InputError when the surface reaches beyond the lattice.
std::vector<uint8_t> classify_nodes(const LatticeGrid& grid, const MaterialSurface& surface);

/// What an update has divided: cells of the version before, and parts of them again.
struct NewParts {
  int32_t known = 0;  // ids of the version before; those from here on are new
  struct Whole {
    std::shared_ptr<const CellComponents> held;  // the divided cell when it was whole, with what has been cut since
    bool named = false;                          // its classes name those of the version before; else they are those
  };
  std::vector<Whole> whole;  // per new division
  bool empty() const { return whole.empty(); }
};

/// Where a cell and its classes come from in the version before.
class Descent {
 public:
  Descent(const LatticeTopology& now, const NewParts& parts) : t_(now), parts_(parts) {}
  bool is_new(int32_t cell) const { return cell >= parts_.known; }
  int32_t cell_before(int32_t cell) const {
    while (is_new(cell)) cell = t_.tree.owner(cell);
    return cell;
  }
  /// Of a class of a new part: its class in cell_before(); -1: it is not known.
  int class_before(int32_t part, int cls) const;

 private:
  const LatticeTopology& t_;
  const NewParts& parts_;
};

/// Classes of a cell, before its copies have been made.
int classes_in(const LatticeTopology& topology, int32_t cell);

/// Numbers the cell copies (kept ones in the order of `previous`, new ones after, by cell and class) and names parents.
/// Of the parts of a copy that was divided the first keeps its number.
void number_copies(LatticeTopology& topology, const LatticeTopology* previous, std::span<const uint8_t> touched,
                   const NewParts& parts);

/// One builder per level, made when first asked for.
class LevelBuilders {
 public:
  LevelBuilders(const LatticeGrid& grid, const MaterialSurface& surface) : grid_(grid), surface_(surface) {}
  CellBuilder& operator[](int level) {
    auto& b = builder_[size_t(level)];
    if (!b) b = std::make_unique<CellBuilder>(grid_.at_level(level), surface_);
    return *b;
  }
  const MaterialSurface& surface() const { return surface_; }
  const LatticeGrid& grid() const { return grid_; }

 private:
  LatticeGrid grid_;
  const MaterialSurface& surface_;
  std::array<std::unique_ptr<CellBuilder>, kLevels + 1> builder_;
};

/// Undivided cells that share (a part of) the + square of
/// undivided `cell` along `axis`; none at the end of the
/// lattice. `high` false: the - square.
void cells_beyond(const LatticeTopology& topology, int32_t cell, int axis, std::vector<int32_t>& out, bool high = true);

/// Links between undivided `cell` and `next`, one of the cells_beyond. Of different levels: through the smaller square.
void find_links(const LatticeTopology& topology, LevelBuilders& builders, int32_t cell, int axis, int32_t next,
                std::vector<Link>& out);

/// Which cells must be divided next, ascending: those of `candidates` that hold a front or that the grading asks for,
/// coarsest first, and before them what their neighbours need. Empty when all is well. Candidates that need no division
/// are dropped. Asks for components only, not for copies.
std::vector<int32_t> cells_to_divide(const LatticeTopology& topology, LevelBuilders& builders,
                                     std::vector<int32_t>& candidates);

/// Divides these cells: tree and components. Copies and all that follows from them are made afterwards. `named`: per id
/// of the version before, whether the cell's classes name those of that version.
void divide_cells(LatticeTopology& topology, LevelBuilders& builders, std::span<const int32_t> cells,
                  std::span<const uint8_t> named, NewParts& parts);

/// skip_version (topology.h) in place.
void skip_parents(const LatticeTopology& middle, LatticeTopology& last);

/// States of the 27 corners of the parts of a cell, from those of its own corners and the faces that may meet it.
std::array<uint8_t, 27> classify_parts(LevelBuilders& builders, const CellPlace& place, uint8_t corners_in,
                                       std::span<const int32_t> faces);

/// All that follows from the components: copies, links, nodes, sums.
void finish_topology(LatticeTopology& topology, LevelBuilders& builders, const LatticeTopology* previous,
                     std::span<const uint8_t> touched, const NewParts& parts);

/// Parents of copies that nothing in their own cell could name, by their neighbours.
void name_parents_by_neighbours(LatticeTopology& topology, const LatticeTopology& previous);

/// The neighbourhood in which nodes are numbered again.
struct NodeRegion {
  std::vector<int32_t> cells;   // with copies: all those near enough to have a say (two undivided cells around)
  std::vector<int32_t> copies;  // of these cells, ascending
  NumberSet changed;            // undivided cells (or what they were divided into) at whose corners nodes may be others
};

/// Node copies from links: ids of kept ones follow their parents' order; when cells have been divided, ids of nodes
/// that are gone pass to new ones. Throws std::logic_error when corners that are one node now were several before.
/// Fills `hanging` and `born`. With a region only what lies at the corners of its changed cells is done again, all else
/// must be as in `previous`; false, and nothing done, when more nodes are gone than are new.
bool number_nodes(LatticeTopology& topology, const LatticeTopology* previous, const NewParts& parts,
                  const NodeRegion* region = nullptr);

/// Pieces, volumes and the hash.
void summarise(LatticeTopology& topology);
/// Are the pieces those of before, of which there were `pieces_before`, now that `changed` cells are parted anew?
/// `place`: per cell, where among the changed ones (-1: it is not).
bool pieces_stay(const LatticeTopology& topology, int32_t pieces_before, std::span<const int32_t> changed,
                 std::span<const int32_t> place);
int128 exact_share(double fraction, int level);     // of an undivided cell, times 2^60
void volumes_from_sums(LatticeTopology& topology);  // of the pieces, from piece_sum

/// finish_topology at the cost of what has changed (local_update.cpp), after a cut that took nothing away, and after a
/// division. `topology` comes as a copy of `previous` with tree and components of now; on false it is to be finished as
/// a whole. `touched`: cells, ascending.
bool finish_locally(LatticeTopology& topology, LevelBuilders& builders, const LatticeTopology& previous,
                    std::span<const int32_t> touched, const NewParts& parts);

/// update_topology; `locally` false: by finish_topology whatever has changed, for tests.
std::shared_ptr<const LatticeTopology> update_topology(const LatticeTopology& previous, const MaterialSurface& surface,
                                                       bool locally, Workers* workers = nullptr,
                                                       Divide divide = Divide::fronts);

}  // namespace limberg
