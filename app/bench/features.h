#pragma once
// `limberg bench features [SCENE]`: what each part of a scene costs, off and on: memory of the patient and CPU time of a step.
//
// A hook is pulled for 24 frames of 10 iterations beside an incision of 40 mm; the step time is the median. Memory is what
// the allocator has handed out for the patient (its body included), after the last frame. A part that is off must cost
// nothing: its rows differ in nothing but the part.
#include <functional>

#include "app/bench/bench.h"
#include "app/scene.h"

namespace limberg::bench {

struct FeatureSettings {
  bool quick = false;  // coarse cells
  std::function<void(const std::string&)> progress;
};

Result features(const Scene& scene, const FeatureSettings& settings);

}  // namespace limberg::bench
