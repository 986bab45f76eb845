#include "app/session/as_recorded.h"

#include <algorithm>
#include <deque>

#include "app/session/clock.h"

namespace limberg {

namespace {

/// Runs the device's ticks and keeps the hands that steps may still ask for.
class Ticks {
 public:
  Ticks(SessionLanes& lanes, const LiveSchedule& schedule, TakenSource& samples, SessionFigures& out)
      : lanes_(lanes), runs_(schedule.device), samples_(samples), out_(out) {}

  /// All that were done on snapshots of steps before this one.
  template <class Each>
  void before_step(int64_t step, Each&& each) {
    for (; next_ < runs_.size() && runs_[next_].snapshot < step; ++next_) {
      const DeviceRun& r = runs_[next_];
      for (int32_t i = 0; i < r.count; ++i) {
        samples_.allow(i == 0 ? r.samples : 0);
        tick_ = r.tick + i;
        const int64_t began = RealClock::monotonic_ns();
        lanes_.device.tick(tick_);
        out_.device.work.add(RealClock::monotonic_ns() - began);
        out_.device.age.add((tick_ - lanes_.device.snapshot_tick()) * kDeviceTickNs);
        ++out_.ticks;
        if (lanes_.device.snapshot_step() != r.snapshot) ++strange_;
        hands_.push_back(lanes_.device.hand());
        each(tick_);
      }
    }
  }
  /// The hand of a tick; null when there was none. Earlier ones are let go.
  const HandState* hand(int64_t tick) {
    while (!hands_.empty() && hands_.front().tool.tick < tick) hands_.pop_front();
    if (hands_.empty() || hands_.front().tool.tick != tick) return nullptr;
    return &hands_.front();
  }
  int64_t tick() const { return tick_; }
  int64_t strange() const { return strange_; }  // ticks that did not find the snapshot that they had then

 private:
  SessionLanes& lanes_;
  const std::vector<DeviceRun>& runs_;
  TakenSource& samples_;
  SessionFigures& out_;
  size_t next_ = 0;
  int64_t tick_ = 0, strange_ = 0;
  std::deque<HandState> hands_;
};

void once_more(SessionLanes& lanes, const SessionSettings& set, const LiveSchedule& schedule, TakenSource& samples,
               SessionFigures& out) {
  lanes.solver.start();
  lanes.render.prepare();
  Ticks ticks(lanes, schedule, samples, out);
  int64_t last_step = -1;  // its tick
  int64_t frames = -1;     // the frame whose time has come last
  const auto frame = [&](int64_t tick) {
    for (; frames < tick / set.ticks_per_frame; ++frames) {  // a film has every frame, whatever ticks were skipped
      const int64_t began = RealClock::monotonic_ns();
      if (lanes.render.frame()) out.render.work.add(RealClock::monotonic_ns() - began), ++out.render.ticks;
      if (!lanes.render.open()) out.interrupted = true;
    }
  };
  for (const SolverTake& take : schedule.solver) {
    ticks.before_step(take.step, frame);
    out.last_tick = take.tick, out.duration_s = double(take.tick) * 1e-3;
    const int64_t began = RealClock::monotonic_ns();
    lanes.solver.step_as(take, take.hand_tick < 0 ? nullptr : ticks.hand(take.hand_tick));
    if (lanes.recorder) lanes.recorder->drain();
    out.solver.work.add(RealClock::monotonic_ns() - began);
    ++out.solver.ticks;
    // Whole periods that went by without a step, then.
    if (last_step >= 0)
      out.solver.skipped += uint64_t(std::max<int64_t>(
          0, (take.tick - last_step + set.ticks_per_solver_step / 2) / set.ticks_per_solver_step - 1));
    last_step = take.tick;
    if (take.hash != 0) {
      ++out.hashes_compared;
      if (lanes.solver.state_hash() == take.hash)
        ++out.hashes_equal;
      else if (out.first_difference_tick < 0)
        out.first_difference_tick = take.tick;
    }
    if (set.progress && out.solver.ticks % 8 == 0) set.progress(take.tick);
    if (set.interrupted && set.interrupted()) out.interrupted = true;
    if (out.interrupted) break;
  }
  if (!out.interrupted) ticks.before_step(lanes.solver.steps() + 1, frame);
  if (ticks.strange() > 0 && out.first_difference_tick < 0) out.first_difference_tick = ticks.tick();
  out.last_tick = ticks.tick();
  out.duration_s = double(out.last_tick) * 1e-3;
  if (lanes.recorder) lanes.device.end_schedule(), lanes.recorder->drain();
  out.checkpoints.push_back({out.last_tick, lanes.solver.state_hash()});
  if (set.goes_on) return;
  // A session that was cut short is brought to rest here.
  while (!out.interrupted && out.settle_steps < set.settle_steps && !lanes.solver.at_rest(set.settle_residual)) {
    lanes.solver.settle_step(out.last_tick);
    ++out.settle_steps, ++out.solver.ticks;
    if (set.interrupted && set.interrupted()) out.interrupted = true;
  }
  lanes.render.frame();
  lanes.render.finish();
  out.state_hash = lanes.solver.state_hash();
}

}  // namespace

SessionFigures run_as_recorded(SessionLanes lanes, const SessionSettings& set, const LiveSchedule& schedule,
                               TakenSource& samples) {
  SessionFigures out;
  try {
    once_more(lanes, set, schedule, samples, out);
  } catch (...) {
    if (lanes.recorder) lanes.recorder->cut_short();
    fail_session("replay", out);
  }
  return out;
}

}  // namespace limberg
