#pragma once
// `limberg bench laws`: what near-incompressibility costs under
// every law, and how well layers thinner than a cell are kept.
//
//   nu        the scene of the speed bench (box_model.h: held sides,
//             fusiform hole, 20 sutures, a hook pulled by 30 mm in one
//             jump) with the law in both layers (fibres: in the skin) at nu
//             .3, .45, .49, .499: iterations until the largest nodal error
//             stays below 0.1 mm, error against the same model converged.
//             Bars: .49 at most 1.5 times, .499 at most twice those of .3
//   layers    1.5 mm of skin on fat in cells of 3 mm, against cells
//             of 0.75 mm that resolve the skin, the same forces: a
//             patch of the skin pulled up by a hook, a clamped beam 9
//             mm thick and a flap 3 mm thick bent by a load at their
//             ends. Error of the displacement under the load; bar 5 %
#include <functional>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct LawsSettings {
  bool quick = false;  // 2k nodes; the layers with one stiffness only
  std::function<void(const std::string&)> progress;
};

Result laws(const LawsSettings& settings);
Result layers(const LawsSettings& settings);

}  // namespace limberg::bench
