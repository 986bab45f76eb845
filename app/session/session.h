#pragma once
// A session: the lanes, who drives them, and what it came to.
//
// Two drivers run the same lanes: lockstep.h on a virtual clock in one thread, realtime.h with three threads. Both end
// when the sources have ended (or at a given tick), then let the patient come to rest.
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/session/device_lane.h"
#include "app/session/gauges.h"
#include "app/session/lanes.h"
#include "app/session/recorder.h"
#include "app/session/render_lane.h"
#include "app/session/solver_lane.h"
#include "devices/session_time.h"

namespace limberg {

struct SessionLanes {
  DeviceLane& device;
  SolverLane& solver;
  RenderLane& render;
  Recorder* recorder = nullptr;
};

struct SessionSettings {
  int ticks_per_solver_step = 16;  // 62.5 Hz
  int ticks_per_frame = 33;        // 30 frames a second
  int64_t first_tick = 0;          // real time: after an earlier part was done again (goes_on); a whole solver step
  int64_t end_tick = -1;           // the last tick; -1: `tail_ticks` after the sources have ended
  bool goes_on = false;            // lockstep, as recorded: an earlier part. It is left as it stands, its recorder open
  int64_t tail_ticks = 100;        // time for the filter to catch up and the last gesture to end
  int64_t checkpoint_ticks = 1000;  // lockstep
  // Afterwards: steps until the residual is reached, at most so many.
  double settle_residual = 1e-5;
  int settle_steps = 600;
  bool settle_when_closed = false;  // even when the window was closed; else the session ends then as it stands
  bool stop_when_recording_fails = false;
  // Real time: a hand that is emulated or recorded waits for the patient. Where a solver step takes longer than its
  // period the session's clock is held, so that none is skipped; a live hand cannot wait and is told.
  bool hand_waits = false;
  // Real time, a live hand: the session's clock runs slower than the wall's while the patient is behind
  // (slow_motion.h). Whoever stamps samples stamps by the same line. Null: it never does. Not with hand_waits.
  std::shared_ptr<SlowedTime> slow_motion;
  LaneGauges* gauges = nullptr;       // real time: filled while it runs
  std::function<void()> pump;         // real time: called every few ms from the calling thread (a window's events)
  std::function<bool()> interrupted;  // asked now and then, from the driver's thread
  std::function<void(int64_t tick)> progress;   // the same
  std::function<void(const std::string&)> say;  // one line for the user, from the driver's thread
};

/// What a run came to; the lanes keep the rest (refusals, stages, series).
struct SessionFigures {
  LaneTimes device, solver, render;
  Histogram sample_to_snapshot, sample_to_frame;
  int64_t ticks = 0;  // device ticks done
  int64_t last_tick = 0;
  double duration_s = 0;  // of the session's clock, without the rest afterwards
  int settle_steps = 0;
  uint64_t state_hash = 0;              // at the end, at rest
  std::vector<Checkpoint> checkpoints;  // lockstep: the last one is at the last tick, before the rest afterwards
  // A live session done again: hashes that its steps carry, compared; the first tick that differs, -1: none.
  int64_t hashes_compared = 0, hashes_equal = 0, first_difference_tick = -1;
  bool interrupted = false;
  std::string hand;        // real time: "waits", "slowed" (slow motion) or "live"
  int64_t waited_ns = 0;   // real time: for so long the session's clock was held (SessionSettings::hand_waits)
  int64_t slowed_ns = 0;   // slow motion: so much longer did the session last by the wall's clock than by its own
  double slowest = 1;      // slow motion: of the wall's pace, over the slowest second
  bool closed = false;     // real time: the window was
  std::string scheduling;  // real time: what the device thread got
};

/// A lane has failed, and with it the session. The threads have ended, and the recorder holds everything up to there.
struct SessionFailure : std::runtime_error {
  SessionFailure(const std::string& where_, const std::string& what, SessionFigures figures_, std::exception_ptr cause_)
      : std::runtime_error(where_ + ": " + what), where(where_), figures(std::move(figures_)), cause(cause_) {}
  std::string where;       // "solver thread"
  SessionFigures figures;  // as far as they had come
  std::exception_ptr cause;
};
/// What an exception says of itself.
std::string words_of(const std::exception_ptr& error);
/// Within a catch: throws the exception on as the failure of a session.
[[noreturn]] void fail_session(const std::string& where, const SessionFigures& figures);

}  // namespace limberg
