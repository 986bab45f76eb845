#pragma once
// How much of a large model is solved for while a hand carries something (focus_solver.h).
#include <cstddef>

namespace limberg::fem {

struct FocusSettings {
  size_t from_nodes = 8000;  // smaller models are fast enough
  double reach_mm = 20;      // at first: about two thicknesses of a face's soft tissue, over which a move fades to a
                             // twentieth where the deep side is held
  double budget_mm = 0.05;   // half of the lag that a live hand may see
  double worth = 0.6;        // a part with more of the nodes gains nothing
};

}  // namespace limberg::fem
