#pragma once
// `limberg bench stability`: what may happen to tissue, and whether the solver comes back from it.
//
// Every case is a model, a disturbance and a release. A case passes when,
//   physically (not merely without a NaN): - every displacement and energy is
//   finite in every step; - under loads that stay: the sutures or hooks reach what
//   they ask for, to a residual of 1e-3; - after the release it returns to its
//   rest shape: no node farther than 1/1000 of the longest side (a floating piece:
//     after the best rigid motion is taken out), no cell inverted, within 300 steps of 40 iterations (5 s at 60 Hz);
//   - a moving floating piece keeps its momentum to 1e-6 of sum |m v| (single precision: 2e-6 a step is allowed for);
//   - no state after the release holds more elastic energy than the disturbed one did.
// The peers get the same model, disturbance and release. Quasi-static cases, 200
// iterations: full Newton (adaptive projection, CHOLMOD) on the same energy, and
// full Newton on the linear corotated law, as most real-time systems use it. Cases
// of one tissue, 100 steps (of the case's length, or 1/60 s): Bullet's deformable
// body on five tetrahedra a cell (bullet_peer.h), which passes when it is finite
// and within 1/1000 of the longest side of rest at any time after the release.
#include <functional>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct StabilitySettings {
  bool quick = false;                                // one case per family, no peers
  bool peers = true;                                 // without them it is a matter of seconds
  std::string only;                                  // families and cases whose name contains this
  std::function<void(const std::string&)> progress;  // empty: silent
};

Result stability(const StabilitySettings& settings);

}  // namespace limberg::bench
