#pragma once
// Cells that each have a stencil of their own, laid out for a cell to a lane.
//
// On a block of tissue most cells share a handful of stencils, and a run of one is taken a cell to a lane with the
// stencil's numbers in common. On a face nearly every cell has its own (the surface cuts each one elsewhere), and taken
// one by one they cost 1.25 to 1.8 times as much (bench speed, 2026-11-28). Blocks of sixteen hold the numbers as the
// lanes want them, once; the kernels (kernels.h) then do the same operations in the same order as one by one, and add
// up in the order of the cells.
#include <memory>
#include <span>
#include <vector>

#include "sim/base/simd.h"
#include "sim/fem/kernels/kernels.h"

namespace limberg::fem {

/// Of a tile. Never changed once made.
struct LaneBlocks {
  AlignedArray<LaneBlock> block;
  std::vector<LaneBlock::Kind> kind;  // per cell of the tile
};

/// Null when no cells are worth it. Runs of one stencil that are taken together anyway are left to that.
std::shared_ptr<const LaneBlocks> lane_blocks(const KernelStencil* stencils, std::span<const KernelCell> tile);

}  // namespace limberg::fem
