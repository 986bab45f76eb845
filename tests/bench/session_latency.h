#pragma once
// The part of `limberg bench devices` that needs a whole session: from a reading to the patient that has seen it and to
// the picture that shows it, with and without real-time priority, alone and with a busy thread for each core.
#include <functional>
#include <string>
#include <vector>

#include "app/operating_point/bench.h"
#include "app/scene/scene.h"
#include "devices/sample.h"

namespace limberg::bench {

/// Runs the samples in real time on `scene`, four times; each takes as long as they do.
void add_session_latency(Result& out, const Scene& scene, const std::vector<Sample>& samples, bool quick,
                         const std::function<void(const std::string&)>& progress);

}  // namespace limberg::bench
