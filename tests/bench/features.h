#pragma once
// `limberg bench features [SCENE]`: what each part of a scene
// costs, off and on: memory of the patient and CPU time of a step.
//
// A hook is pulled for 48 frames of 10 iterations, most of them beside an incision of 40 mm. The variants of a part
// are stepped in turn, frame by frame, and compared frame by frame; the first, off, runs twice, and how far it differs
// from itself is the noise of the run. Memory is what the allocator has handed out for the patient (its body included)
// when it was made. A part that is there with nothing to do must cost nothing: no more than 2 % and that noise.
#include <functional>

#include "app/operating_point/bench.h"
#include "app/scene/scene.h"

namespace limberg::bench {

struct FeatureSettings {
  bool quick = false;  // coarse cells
  std::string only;    // parts whose name contains this
  std::function<void(const std::string&)> progress;
};

Result features(const Scene& scene, const FeatureSettings& settings);

}  // namespace limberg::bench
