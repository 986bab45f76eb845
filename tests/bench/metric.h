#pragma once
// Rows of `limberg bench cutting`: from a cut's new elements to a metric for them, and what is shown meanwhile.
//
//   scene     120 x 120 x 10 mm block of about 8k and 30k nodes, sides
//             held, skin over fat, nu 0.49; a slit of 50 mm through its
//             whole depth, and a flap of 20 mm undermined beside it
//             (Flaps take more steps than slits by any scalar metric, the
//             exact factor included: the metric knows a thin sheet only
//             as a membrane, while it bends at (thickness / length)^2 of
//             that stiffness. At rest and nu 0.3 conjugate gradients with
//             the exact factor need 45 steps on the whole block, 55 with
//             the slit, 77 with a flap of 20 mm, 87 with one of 30 mm,
//             and the lowest Ritz values fall from 0.010 to 0.007, 0.004
//             and 0.003; a longer history changes nothing.)
//   methods   METIS again (assembly, analysis, numeric factor, panels: as a scene
//             opens); the numeric factor in the order of before; the multilevel cycle
//             made afresh; the cycle carried over from the cycle before the cut
//   frames    the lip of the wound is pulled; the block is cut again
//             and stepped as a session does (10 steps of L-BFGS a
//             frame). Per frame the largest move of the surface and
//             the distance to the equilibrium that the frames lead
//             to: a metric that did not fit would overshoot
#include <functional>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct MetricSettings {
  bool quick = false;  // about 2k nodes only, no bars on time
  std::function<void(const std::string&)> progress;
};

Result cut_metric(const MetricSettings& settings);

}  // namespace limberg::bench
