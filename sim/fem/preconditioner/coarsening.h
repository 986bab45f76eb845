#pragma once
// The next coarser lattice of a set of hexahedra, cut tissue included.
//
// Space is divided into blocks of 2 x 2 x 2 cells (of 2 x 2 x 1 when there are few layers and an
// odd number of them). A coarse cell is a connected component of the cells of one block, so tissue
// that a cut has parted inside a block is moved by two coarse cells that know nothing of each
// other. Two coarse cells of neighbouring blocks share a corner exactly when they share a free
// node that this corner interpolates. So holes, flaps and doubled nodes need no case of their own.
//
// A free node is interpolated trilinearly from its coarse cell's corners. All coarse cells around it agree on its row,
// for they share every corner that has a weight there.
//
// Places are counted in eighths of an undivided cell; parts of divided cells lie in the block of their parent.
//
// A graded lattice is made even first: its finest cells are put together to cells of twice their size (or to the next
// size that takes a quarter of the nodes away, at least), the others stay as they are, until all cells are whole. From
// blocks of 2 x 2 x 2 whole cells alone a zone of quarter cells would be thinned 512 to 1 at once, which no smoother
// makes up for. Cells that are put together touch none that is larger than what they make (2 : 1), so all
// corners fit.
#include <array>
#include <span>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

struct GridCell {
  std::array<int32_t, 8> node{};  // -1: a corner that moves nothing
  std::array<int32_t, 3> at{};    // low corner, eighths
  int32_t size = 8;               // edge, eighths
};

/// A lattice as coarsening sees it.
struct GridLevel {
  std::vector<GridCell> cells;
  std::vector<std::array<int32_t, 3>> at;  // per node, eighths
  std::vector<uint8_t> free;               // per node
};

/// Where the blocks lie. Kept over cuts, so that the blocks of before are the blocks of now.
struct BlockRule {
  std::array<int32_t, 3> origin{};  // low corner of block (0, 0, 0)
  std::array<int32_t, 3> size{};    // of a block: 16 or 8 eighths
  int32_t parts_below = 0;          // not 0: only cells smaller than this are put together, to cells of this size
  bool operator==(const BlockRule&) const = default;
};
BlockRule block_rule(const GridLevel& level);
/// Which parts are put together next; parts_below is 0 when all cells are whole.
BlockRule part_rule(const GridLevel& level);

/// Rows of weights: out of row i, `column` ascending.
struct Interpolation {
  std::vector<int32_t> begin{0}, column;
  std::vector<float> weight;
  int32_t rows() const { return int32_t(begin.size()) - 1; }
  bool operator==(const Interpolation&) const = default;
};

struct Coarsening {
  BlockRule rule;
  GridLevel level;             // every node of it is free; numbered by place, copies of a place side by side
  std::vector<int64_t> place;  // per coarse node: a key of its place, ascending
  Interpolation prolong;       // fine node <- coarse nodes, sums to 1 for free nodes, empty for others
  Interpolation restrict_;     // its transpose
};
Coarsening coarsen(const GridLevel& fine, const BlockRule& rule);

/// Elimination order of a lattice's nodes by geometric nested dissection: halve the box across its longest axis, the
/// plane between the halves last. A function of the places alone, so an order need not be remembered over cuts; on a
/// lattice it costs no more fill than a graph partitioner's (tests), in a hundredth of its time.
std::vector<int32_t> dissection_order(std::span<const std::array<int32_t, 3>> at);

/// Eighths of an undivided cell from the rest positions;
/// `zero_mm`: any point of the lattice, the same for all versions.
GridLevel grid_level(const FemModel& model, const Vec3& zero_mm, std::span<const uint8_t> free);

}  // namespace limberg::fem
