#pragma once
// The session on three threads at their own rates, none ever waiting for another:
//
//   device  1 kHz     SCHED_FIFO and locked memory where permitted; no allocation, lock or log call in steady state
//   solver  62.5 Hz   ordinary priority; a step ends early when its period is used up
//   render  <= 30 Hz  nice +5; skipped when nothing changed
//   (the calling thread) writes the recording, looks out for the end
//
// A tick that comes late is done once with the present time; whole ticks that were missed are skipped and counted,
// never run back to back. A device tick that takes longer than 50 ms gives the real-time priority back, so that a
// defect cannot take the machine.
#include "app/session/session.h"

namespace limberg {

struct RealTimeSettings {
  int fifo_priority = 80;
  int render_nice = 5;
  double solver_budget = 0.85;  // of its period, after which a step takes no further iteration
};

/// `before_start` is called once everything is ready, with CLOCK_MONOTONIC of the first tick in ns: the place to start
/// live sources. SessionFailure: one of the threads, this one among them, could not go on; the others were told to end
/// and have ended, and the recording is closed without an end.
SessionFigures run_realtime(SessionLanes lanes, const SessionSettings& settings, const RealTimeSettings& real_time,
                            const std::function<void(int64_t start_ns)>& before_start = {});

}  // namespace limberg
