#pragma once
// `limberg bench frames [SCENE]`: what a frame costs at each
// quality and size, and what the solver loses beside a picture.
//
// The patient is one in the middle of an operation: the scene's shipped script up to its first stitch.
// Times are wall times of frames drawn off screen and read back, the median of several; those of one run
// are comparable, not those of two machines. A picture of 64 x 48 shows what the triangles cost. The
// driver draws on the calling thread alone, as in a session, unless LP_NUM_THREADS says otherwise. The
// solver's loss: steps of a drag with and without a render thread that draws as often as a session's
// does (app/session/drawing_share.h), in turns, in one run, with one worker and with one a core.
#include <functional>

#include "app/operating_point/bench.h"
#include "app/scene/scene.h"
#include "sim/commands/script.h"

namespace limberg::bench {

struct FramesSettings {
  bool quick = false;  // one size, fewer frames
  std::function<void(const std::string&)> progress;
};

/// `script` may be null: then the patient is as the scene has it. RenderUnavailable where no picture can be made.
Result frames(const Scene& scene, const Script* script, const FramesSettings& settings);

}  // namespace limberg::bench
