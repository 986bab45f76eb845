#pragma once
// What the threads of a live session took from each other, and
// when: enough to do it all again, bit for bit, in one thread.
//
// Two things are chance while a session runs against the clock: which snapshot, hand and samples a
// tick or a step found when it looked, and where the clock cut a step short. Both are written down
// beside the samples. Ticks that follow each other on one snapshot without a sample are one row.
#include <cstdint>
#include <vector>

namespace limberg {

/// `count` device ticks in a row, from `tick` on, on the snapshot of one solver step.
struct DeviceRun {
  int64_t tick = 0;
  int64_t snapshot = 0;  // Snapshot::step
  int32_t count = 0;
  int32_t samples = 0;  // handed over in the first of them; none in the others
};

/// One solver step.
struct SolverTake {
  int64_t step = 0;        // from 1
  int64_t tick = 0;        // the time it was given
  int64_t hand_tick = -1;  // device tick of the hand that it found; -1: none yet
  int64_t events = 0;      // tool events taken since the beginning
  int64_t stop_at = 0;     // at which question the clock said stop; 0: never
  uint64_t adopted = 0;    // bit k: at the k-th chance a finished factor was taken (StepSettings::adopt_now)
  uint64_t hash = 0;       // of the state after it, now and then; 0: not given
};

struct LiveSchedule {
  std::vector<DeviceRun> device;
  std::vector<SolverTake> solver;
  bool broken = false;  // rows are missing or cannot be: the session can be replayed, but not exactly
  bool usable() const { return !broken && !device.empty() && !solver.empty(); }
};

}  // namespace limberg
