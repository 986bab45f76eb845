#pragma once
// Rows of `limberg bench cutting`: from a cut's new elements to a metric for them, and what is shown meanwhile.
//
//   scene     120 x 120 x 10 mm block of about 8k and 30k nodes, sides held, skin over fat, nu 0.49; a slit of 50 mm through its
//             whole depth, and a flap of 20 mm undermined beside it
//   methods   METIS again (assembly, analysis, numeric factor, panels: as a scene opens); the numeric factor in the order of
//             before; the multilevel cycle made afresh; the cycle carried over from the cycle before the cut
//   frames    the lip of the wound is pulled; the block is cut again and stepped as a session does (10 steps of L-BFGS a frame).
//             Per frame the largest move of the surface and the distance to the equilibrium that the frames lead to: a metric
//             that did not fit would overshoot
#include <functional>

#include "app/bench/bench.h"

namespace limberg::bench {

struct MetricSettings {
  bool quick = false;  // about 2k nodes only, no bars on time
  std::function<void(const std::string&)> progress;
};

Result cut_metric(const MetricSettings& settings);

}  // namespace limberg::bench
