#pragma once
// The whole session on a virtual clock, in the calling thread: device tick n, then every 16th tick a solver step, every
// 33rd a frame. Nothing that is measured has any influence: the same samples and scene give the same bits, however long
// the work takes.
#include "app/session/session.h"

namespace limberg {

SessionFigures run_lockstep(SessionLanes lanes, const SessionSettings& settings);

}  // namespace limberg
