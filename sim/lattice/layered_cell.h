#pragma once
// What a stencil of several layers was made from, kept so that a copy with another mixture can have one of its own.
#include <cstdint>
#include <map>
#include <vector>

#include "sim/lattice/region_cells.h"

namespace limberg {

/// Depth below the skin in a cell, as the layers count it: at its centre, and its gradient, a unit vector where no
/// layer is thicker by place.
struct CellDepth {
  double at_centre_mm = 0;
  Vec3 down = -Vec3::UnitZ();
};

struct LayeredCell {
  std::vector<CellPart> parts;  // of all of the cell
  StretchFrame frame;
  CellDepth depth;
  /// Stencils of other mixtures, by the layers' shares in steps (copy_layers.h).
  std::map<std::vector<int32_t>, int32_t> mixed;
  double volume_mm3(size_t layer) const {
    double sum = 0;
    for (const CellPart& p : parts)
      if (p.layer == int(layer)) sum += p.moments.volume_mm3();
    return sum;
  }
};

}  // namespace limberg
