#include "app/session/lockstep.h"

#include "app/session/clock.h"

namespace limberg {

namespace {

/// Adds the wall time of f() to a histogram.
template <class F>
void timed(Histogram& h, F&& f) {
  const int64_t before = RealClock::monotonic_ns();
  f();
  h.add(RealClock::monotonic_ns() - before);
}

void in_lockstep(SessionLanes& lanes, const SessionSettings& set, SessionFigures& out) {
  DeviceLane& device = lanes.device;
  SolverLane& solver = lanes.solver;
  RenderLane& render = lanes.render;
  Recorder* const recorder = lanes.recorder;
  VirtualClock clock;
  solver.start();
  render.prepare();
  int64_t tick = 0, end = set.end_tick;
  for (;; ++tick, clock.advance_ns(kDeviceTickNs)) {
    out.last_tick = tick, out.duration_s = double(tick) * 1e-3;
    timed(out.device.work, [&] { device.tick(tick); });
    out.device.age.add((tick - device.snapshot_tick()) * kDeviceTickNs);
    ++out.ticks;
    if (recorder) recorder->drain();
    if (tick % set.ticks_per_solver_step == 0) {
      timed(out.solver.work, [&] { solver.step(tick); });
      ++out.solver.ticks;
      if (solver.published_new_sample()) out.sample_to_snapshot.add(clock.now_ns() - solver.newest_sample_ns());
    }
    if (tick % set.ticks_per_frame == 0) {
      const int64_t before = RealClock::monotonic_ns();
      if (render.frame()) {
        out.render.work.add(RealClock::monotonic_ns() - before);
        ++out.render.ticks;
        out.sample_to_frame.add(clock.now_ns() - render.sample_ns());
      }
      if (!render.open()) out.interrupted = true;
    }
    const bool last = out.interrupted || (end >= 0 && tick >= end);
    if (last && set.goes_on) return;
    if (last || (tick > 0 && tick % set.checkpoint_ticks == 0)) {
      out.checkpoints.push_back({tick, solver.state_hash()});
      if (recorder && !last) recorder->checkpoint(tick, out.checkpoints.back().hash);
    }
    if (set.progress && tick % 100 == 0) set.progress(tick);
    if (last) break;
    if (end < 0 && device.done()) end = tick + set.tail_ticks;
    if (tick % 64 == 0 && set.interrupted && set.interrupted()) out.interrupted = true;
    if (recorder && recorder->failed() && set.stop_when_recording_fails) recorder->give_up(), out.interrupted = true;
  }
  if (recorder) recorder->finish(tick, out.checkpoints.back().hash);
  if (!out.interrupted)
    while (out.settle_steps < set.settle_steps && (out.settle_steps == 0 || !solver.at_rest(set.settle_residual))) {
      timed(out.solver.work, [&] { solver.settle_step(tick); });
      ++out.settle_steps, ++out.solver.ticks;
      if (set.interrupted && set.interrupted()) {
        out.interrupted = true;
        break;
      }
    }
  render.frame();
  render.finish();
  out.state_hash = solver.state_hash();
}

}  // namespace

SessionFigures run_lockstep(SessionLanes lanes, const SessionSettings& set) {
  SessionFigures out;
  try {
    in_lockstep(lanes, set, out);
  } catch (...) {
    if (lanes.recorder) lanes.recorder->cut_short();
    fail_session("session", out);
  }
  return out;
}

}  // namespace limberg
