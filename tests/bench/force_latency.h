#pragma once
// The part of `limberg bench devices` that measures from hand to force: a client in the place of a laboratory's device
// sends its poses over LCM to a live session, and takes the force that answers each; with and without real-time
// priority, alone and with a busy thread for each core. Both clocks are this machine's.
#include <functional>
#include <string>

#include "tests/bench/suite.h"

namespace limberg::bench {

/// Four sessions on `scene`, each some seconds long; rows, a bar, and the chart of what share came later than a time.
void add_force_latency(SuiteOutcome& out, const Scene& scene, bool quick,
                       const std::function<void(const std::string&)>& progress);

}  // namespace limberg::bench
