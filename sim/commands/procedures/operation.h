#pragma once
// A figure carried out: excision, incision, undermining, hooks,
// key stitches, rows, with a stage after each, as a script.
//
// Flaps that change places (Figure::exchanged) are carried as flap_exchange.h says, one after the other.
#include <vector>

#include "sim/commands/procedures/figure.h"
#include "sim/commands/procedures/placement.h"
#include "sim/commands/script.h"

namespace limberg {

struct OperationPlan {
  double depth_mm = 4;
  double undermine_margin_mm = 12;  // of the pocket around the figure; 0: not undermined
  double spacing_mm = 4;            // of stitches
  // Of a layer of buried stitches under those of the skin, sewn before them: wall lies on wall then, and no edge rolls
  // under. 0: none.
  double buried_mm = 0;
  double inset_mm = 0.7, corner_mm = 0.9;  // of a stitch from its edge, and from the tip of a corner
  double lift_mm = 10;                     // height of the hooks while a flap is carried over
};

/// The commands in a surgeon's order. InputError when the figure does not close or leaves the skin.
std::vector<Command> carry_out(const Figure& figure, const OnSkin& where, const OperationPlan& plan = {});

}  // namespace limberg
