#pragma once
// A live session once more, bit for bit, in the calling thread: every device tick on the
// snapshot, and every solver step with the hand, the events and the cuts by the clock, that it
// had (devices/schedule.h). However the threads were interleaved then, a tick's results depend
// only on what it found; so ticks and steps are done in an order in which each finds the same.
#include "app/session/session.h"
#include "devices/taken_source.h"

namespace limberg {

/// `samples` is among the sources of lanes.device. Ends where the schedule ends; a session that was killed has as much
/// of it as was on the disk (read_recording trims it to what is certain). SessionFigures::checkpoints are those of the
/// steps that carry a hash, compared there and then.
SessionFigures run_as_recorded(SessionLanes lanes, const SessionSettings& settings, const LiveSchedule& schedule,
                               TakenSource& samples);

}  // namespace limberg
