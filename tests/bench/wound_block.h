#pragma once
// A held block with a slit through it, undermined on one side
// or not: what a cut does to the minimiser, without cutting.
#include "sim/fem/model/fem_model.h"

namespace limberg::bench {

/// 120 x 120 x 10 mm, sides held, 18 kPa below and 60 kPa above, nu .49.
FemModel sided_block(int cells_per_side, int layers);

/// A slit of 50 mm along x through the middle; flap_mm > 0: undermined so far beside it, half of the layers above.
/// Cells stay in their order, so that a cell's parent is its own index.
FemModel wounded_block(const FemModel& before, double flap_mm);

/// On the slit's lip; pulled: up and away, this part of 14.4 mm.
Spring lip_hook(const FemModel& model, double pulled);

}  // namespace limberg::bench
