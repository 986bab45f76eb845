#pragma once
// The parts that topology.cpp is put together from.
#include "sim/lattice/cell_builder.h"
#include "sim/lattice/topology.h"

namespace limberg {

/// Which lattice nodes lie in the material: every lattice line along x is walked through all that it hits. Throws
/// InputError when the surface reaches beyond the lattice.
std::vector<uint8_t> classify_nodes(const LatticeGrid& grid, const MaterialSurface& surface);

/// Numbers the cell copies (kept ones in the order of `previous`, new ones after, by cell and class) and names parents.
/// Parts of cells that `previous` has whole are new; their parents are the copies of the whole.
void number_copies(LatticeTopology& topology, const LatticeTopology* previous, std::span<const uint8_t> touched);

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

/// Undivided cells that share (a part of) the + square of undivided `cell` along `axis`; none at the end of the lattice.
void cells_beyond(const LatticeTopology& topology, int32_t cell, int axis, std::vector<int32_t>& out);

/// Links between undivided `cell` and `next`, one of the cells_beyond. Of different levels: through the smaller square.
void find_links(const LatticeTopology& topology, LevelBuilders& builders, int32_t cell, int axis, int32_t next,
                std::vector<Link>& out);

/// Which cells must be divided next, ascending: those of `candidates` that hold a front, coarsest first, and before them
/// what the grading needs. Empty when all is well.
std::vector<int32_t> cells_to_divide(const LatticeTopology& topology, LevelBuilders& builders,
                                     std::span<const uint8_t> candidates);

/// The version in which these cells are divided; the surface is the same. Parents index `topology`. `touched`: the
/// divided cells and their parts.
std::shared_ptr<LatticeTopology> divide_cells(const LatticeTopology& topology, LevelBuilders& builders,
                                              std::span<const int32_t> cells, std::vector<uint8_t>& touched);

/// skip_version (topology.h) in place.
void skip_parents(const LatticeTopology& middle, LatticeTopology& last);

/// States of the 27 corners of the parts of a cell, from those of its own corners and the faces that may meet it.
std::array<uint8_t, 27> classify_parts(LevelBuilders& builders, const CellPlace& place, uint8_t corners_in,
                                       std::span<const int32_t> faces);

/// All that follows from the components: copies, links, nodes, sums.
void finish_topology(LatticeTopology& topology, LevelBuilders& builders, const LatticeTopology* previous,
                     std::span<const uint8_t> touched);

/// Parents of copies that nothing in their own cell could name, by their neighbours.
void name_parents_by_neighbours(LatticeTopology& topology, const LatticeTopology& previous);

/// Node copies from links: ids of kept ones follow their parents' order. Throws std::logic_error when corners that are
/// one node now were several before. Fills `hanging` and `born`.
void number_nodes(LatticeTopology& topology, const LatticeTopology* previous);

/// Pieces, volumes and the hash.
void summarise(LatticeTopology& topology);
int128 exact_share(double fraction, int level);     // of an undivided cell, times 2^60
void volumes_from_sums(LatticeTopology& topology);  // of the pieces, from piece_sum

/// finish_topology at the cost of what the cut has changed (local_update.cpp). False, and nothing done, when it took
/// something away, or when cells are divided. `touched`: cells, ascending; `place`: per cell, where among them (-1: it is not).
bool finish_locally(LatticeTopology& topology, LevelBuilders& builders, const LatticeTopology& previous,
                    std::span<const int32_t> touched, std::span<const int32_t> place);

/// update_topology; `locally` false: by finish_topology whatever has changed, for tests.
std::shared_ptr<const LatticeTopology> update_topology(const LatticeTopology& previous, const MaterialSurface& surface,
                                                       bool locally, Workers* workers = nullptr);

}  // namespace limberg
