#pragma once
// `limberg bench speed`: the elasticity solver against full Newton with CHOLMOD, in one process, on one core, in CPU time.
//
//   cold pull   rest -> hook pulled by 30 mm with 20 sutures, in one jump; CPU time until the largest nodal error stays
//               below 1 mm and 0.1 mm. Symbolic work and the constant factor are left out on both sides; Newton's own
//               assembly and factorization are in. Baseline: the better of projected and adaptive Newton.
//   drag        hook moved 1 mm per frame (60 mm/s at 60 Hz) for 30 frames, then held; 16.7 ms of CPU per frame; error
//               against the true equilibrium of the current target.
//
// Scene: BenchScene of sim/fem/box_model.h (120 x 120 x 10 mm, 60 kPa over 18 kPa, fusiform hole).
#include <functional>

#include "app/bench/bench.h"

namespace limberg::bench {

struct SpeedSettings {
  bool quick = false;             // about 2k nodes only, no drag
  double newton_limit_ms = 15000; // CPU time given to each Newton variant per case
  std::function<void(const std::string&)> progress;  // empty: silent
};

Result speed(const SpeedSettings& settings);

}  // namespace limberg::bench
