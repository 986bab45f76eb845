#pragma once
// A flat block of skin on fat in cells that the skin does not fill: every row of cells is the exact sum of the layers
// in it, and a row that both share lets them slide, as lattices have it (lattice/shared_cells.h).
#include "sim/fem/model/fem_model.h"

namespace limberg::bench {

struct LayeredBlock {
  Int3 cells{20, 20, 3};
  Vec3 size_mm{60, 60, 9};  // centred in x and y, z from 0
  double skin_mm = 1.5;     // the uppermost
  double skin_kPa = 60, fat_kPa = 15, poisson = 0.49;
};

/// Nothing is fixed.
FemModel layered_block(const LayeredBlock& block);

}  // namespace limberg::bench
