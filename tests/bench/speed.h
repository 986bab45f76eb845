#pragma once
// `limberg bench speed`: the elasticity solver against full
// Newton with CHOLMOD, in one process, on one core, in CPU time.
//
//   cold pull   rest -> hook pulled by 30 mm with 20 sutures, in one jump; CPU time until the largest nodal error stays
//               below 1 mm and 0.1 mm. Symbolic work and the constant factor are left out on both sides; Newton's own
//               assembly and factorization are in. Baseline: the better of projected and adaptive Newton.
//   kernels     time of a step's parts with AVX-512, AVX2 and plain vectors; three right-hand sides by panels against
//   CHOLMOD
//   scalar      the cold pull at 30k nodes against L-BFGS in scalar double with CHOLMOD's factor and no multipliers
//   workers     wall time of an iteration with one and two workers, the second core free and taken by another job
//   locking     energy of a bent strip two cells thick at Poisson's ratio .49: ours, linear tetrahedra, full hexahedra
//   slab        the peers' slab (speed_slab.cpp): a converged 10 ms step while its middle is pulled by 20 mm
//   bullet      the cold pull on tetrahedra with the energy of Bullet's deformable body, against that body
//   drag        hook moved 1 mm per frame (60 mm/s at 60 Hz) for 30 frames, then held; 16.7 ms of CPU per frame; error
//               against the true equilibrium of the current target.
//
// Scene: BenchScene of sim/fem/model/box_model.h (120 x 120 x 10 mm, 60 kPa over 18 kPa, fusiform hole).
#include <functional>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct SpeedSettings {
  bool quick = false;  // about 2k nodes only, no drag
  // parts whose name contains this: pull 2k, 8k, 30k; kernels, profile, scalar, workers, locking, slab, flap, region,
  // bullet; drag 8k, 30k, 100k
  std::string only;
  double newton_limit_ms = 15000;                    // CPU time given to each Newton variant per case
  std::function<void(const std::string&)> progress;  // empty: silent
};

Result speed(const SpeedSettings& settings);

}  // namespace limberg::bench
