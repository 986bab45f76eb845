#pragma once
// `limberg bench frames [SCENE]`: what a frame costs at each quality and size, and what the solver loses beside a picture.
//
// The patient is one in the middle of an operation: the scene's shipped script up to its first stitch. Times are wall times of
// frames drawn off screen and read back, the median of several; those of one run are comparable, not those of two machines.
// The solver's loss: steps of a drag with and without a render thread at 30 frames a second, in turns, in one run.
#include <functional>

#include "app/bench/bench.h"
#include "app/scene.h"
#include "sim/tools/script.h"

namespace limberg::bench {

struct FramesSettings {
  bool quick = false;  // one size, fewer frames
  std::function<void(const std::string&)> progress;
};

/// `script` may be null: then the patient is as the scene has it. RenderUnavailable where no picture can be made.
Result frames(const Scene& scene, const Script* script, const FramesSettings& settings);

}  // namespace limberg::bench
