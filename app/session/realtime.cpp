#include "app/session/realtime.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <optional>

#include "app/session/clock.h"
#include "app/session/drawing_share.h"
#include "app/session/pace_watch.h"
#include "app/session/slow_motion.h"
#include "app/session/thread.h"

namespace limberg {

namespace {

constexpr int64_t kMostTickNs = 50 * kNsPerMs;  // of a device tick; longer, it is no real-time thread any more
constexpr int64_t kSilentNs = 500 * kNsPerMs;   // a device tick that has not ended: seen from outside

/// What the threads share beside the channels: when to start, when to end, and why.
struct Control {
  std::atomic<int64_t> start_ns{0};  // set once; waited for
  std::atomic<int> ready{0};
  std::atomic<bool> stop_device{false}, stop_solver{false}, stop_render{false};
  std::atomic<bool> device_ended{false}, at_rest{false}, closed{false};
  std::atomic<int64_t> tick{0};
  std::atomic<int64_t> behind_ms{0};  // of the patient that the device's last tick had
  std::atomic<int64_t> held_ns{0};    // of the session's clock, by the solver thread
  std::atomic<int64_t> step_tick{0};  // of the solver step that is being done or was last
  std::atomic<uint64_t> skipped{0};   // solver steps
  std::mutex mutex;                   // for `error` and `scheduling`, at start and end only
  std::exception_ptr error;
  std::string where;  // the error was
  std::string scheduling;
  pthread_t device_id{};  // set before the device thread is ready
  std::atomic<bool> device_gave_up{false};
  DrawingShare drawing;

  void i_am_ready() {
    ready.fetch_add(1);
    ready.notify_all();
  }
  int64_t wait_for_start() {
    start_ns.wait(0);
    return start_ns.load();
  }
  void wait_until_ready(int threads) {
    for (int r = ready.load(); r < threads; r = ready.load()) ready.wait(r);
  }
  void start(int64_t at_ns) {
    start_ns.store(at_ns);
    start_ns.notify_all();
  }
  void end_render() {
    stop_render.store(true);
    stop_render.notify_all();
  }
  /// Tells every thread to end, those too that wait for the start.
  void end() {
    stop_device = stop_solver = true;
    end_render();
    if (start_ns.load() == 0) start(RealClock::monotonic_ns());
  }
  void fail(const std::string& thread) {
    {
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception(), where = thread;
    }
    stop_device = stop_solver = true;
    end_render();
  }
  bool failed() {
    const std::lock_guard lock(mutex);
    return error != nullptr;
  }
};

/// Runs a thread's body; an exception ends the session instead of the program.
template <class F>
std::function<void()> guarded(Control& c, const char* thread, F body) {
  return [&c, thread, body] {
    try {
      body();
    } catch (...) {
      c.fail(thread);
      c.i_am_ready();
    }
  };
}

/// The threads of a session. Whatever happens, they are told to end before somebody waits for them.
struct Crew {
  Control& control;
  std::optional<ScheduledThread> solver, render, device;
  explicit Crew(Control& c) : control(c) {}
  ~Crew() {
    control.end();
    device.reset(), solver.reset(), render.reset();
    unlock_memory();
  }
};

/// A hand that waits goes no farther than the step after the one that the solver is at.
void wait_for_patient(const Control& c, int64_t tick, int ticks_per_step) {
  const timespec pause{0, 200'000};
  while (tick > c.step_tick.load() + ticks_per_step && !c.stop_device.load(std::memory_order_relaxed))
    clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
}

/// A real-time thread that does not end its work would keep everything else from the processor.
void give_up_real_time(Control& c, pthread_t thread) {
  const sched_param normal{};
  pthread_setschedparam(thread, SCHED_OTHER, &normal);
  c.device_gave_up.store(true, std::memory_order_relaxed);
}

void device_thread(Control& c, DeviceLane& lane, LaneTimes& t, const SessionSettings& set, int priority) {
  LaneGauges* const gauges = set.gauges;
  request_exact_timers();
  {
    const std::string got = request_real_time(priority);
    const std::lock_guard lock(c.mutex);
    c.scheduling = got;
    c.device_id = pthread_self();
  }
  c.i_am_ready();
  const PacedClock clock(c.wait_for_start(), c.held_ns, set.slow_motion.get());
  int64_t tick = set.first_tick, end = set.end_tick;
  while (!c.stop_device.load(std::memory_order_relaxed)) {
    if (set.hand_waits) wait_for_patient(c, tick, set.ticks_per_solver_step);
    clock.sleep_until_ns(tick * kDeviceTickNs);
    const int64_t woke = clock.wall_ns(), late = clock.now_ns() - tick * kDeviceTickNs;
    t.wake.add(late);
    if (late >= kDeviceTickNs) {
      ++t.late;
      const int64_t missed = late / kDeviceTickNs;
      t.skipped += uint64_t(missed);
      tick += missed;
    }
    if (end >= 0 && tick > end) tick = end;  // the last tick of a recording is always done
    lane.tick(tick);
    const int64_t ended = clock.wall_ns();
    t.work.add(ended - woke);
    t.age.add((tick - lane.snapshot_tick()) * kDeviceTickNs);
    ++t.ticks;
    c.tick.store(tick, std::memory_order_relaxed);
    c.behind_ms.store(tick - lane.snapshot_tick(), std::memory_order_relaxed);
    if (gauges) {
      LaneGauges::set(gauges->behind_ms, tick - lane.snapshot_tick());
      LaneGauges::set(gauges->tick, tick);
      LaneGauges::set(gauges->device_late, int64_t(t.late));
      LaneGauges::set(gauges->device_ns, ended - woke);
      if (lane.hand().sample_ns != LaneGauges::get(gauges->sample_ns)) {
        LaneGauges::set(gauges->sample_ns, lane.hand().sample_ns);
        LaneGauges::set(gauges->samples, LaneGauges::get(gauges->samples) + 1);
      }
    }
    if (ended - woke > kMostTickNs) give_up_real_time(c, pthread_self());
    if (end < 0 && lane.done()) end = tick + set.tail_ticks;
    if (end >= 0 && tick >= end) break;
    ++tick;
  }
  c.device_ended.store(true);
}

void solver_thread(Control& c, SolverLane& lane, SessionFigures& out, const SessionSettings& set, double budget) {
  LaneTimes& t = out.solver;
  if (set.first_tick == 0) lane.start();
  c.i_am_ready();
  const PacedClock clock(c.wait_for_start(), c.held_ns, set.slow_motion.get());
  const int64_t period = int64_t(set.ticks_per_solver_step) * kDeviceTickNs;
  int64_t n = set.first_tick / set.ticks_per_solver_step + 1, last_tick = set.first_tick;
  int resting = -1;  // steps since the device thread ended
  const bool slow = set.slow_motion != nullptr;
  Slowing slowing(set.slow_motion.get(), period, set.first_tick * kDeviceTickNs, clock.wall_ns());
  while (!c.stop_solver.load()) {
    clock.sleep_until_ns(n * period);
    int64_t late = clock.now_ns() - n * period;
    const int64_t woke = clock.wall_ns();
    t.wake.add(late);
    const int64_t missed = slow ? slowing.given_up(late) : late / period;
    if (set.hand_waits) {
      // Time stands still for what the last step took too long: the hand is where it would have been.
      if (late >= kNsPerMs) c.held_ns.fetch_add(late);
      c.step_tick.store(n * set.ticks_per_solver_step);
    } else if (missed > 0) {
      ++t.late;
      t.skipped += uint64_t(missed);
      c.skipped.fetch_add(uint64_t(missed), std::memory_order_relaxed);
      n += missed, late -= missed * period;
    }
    const bool ended = c.device_ended.load();  // before the step: then the step sees the last event
    if (ended) slowing.let_go(woke);
    const int64_t deadline = woke + int64_t(budget * double(period));
    // A step that is made up for is of its own time, and how far it is behind the hand is told by that.
    const int64_t hand_tick = c.tick.load();
    last_tick = std::max(last_tick, slow ? std::min(hand_tick, n * set.ticks_per_solver_step) : hand_tick);
    c.drawing.step_begins(woke);
    // A step that is cut short leaves the tissue farther behind the hand. One that waits need not bear that, or what
    // comes of an operation would depend on the machine.
    lane.step(last_tick, [&] { return !set.hand_waits && clock.wall_ns() > deadline; });
    const int64_t done = clock.wall_ns();
    c.drawing.step_ended(done, lane.last().iterations);
    t.work.add(done - woke);
    ++t.ticks;
    slowing.ended(n * period, late, woke, done);
    if (set.gauges) LaneGauges::set(set.gauges->solver_ns, done - woke);
    if (lane.published_new_sample()) out.sample_to_snapshot.add(clock.now_ns() - lane.newest_sample_ns());
    if (ended && ++resting >= 1) {
      out.settle_steps = resting;
      if (lane.at_rest(set.settle_residual) || resting >= set.settle_steps) break;
      if (c.closed && !set.settle_when_closed) break;
    }
    ++n;
  }
  slowing.let_go(clock.wall_ns());
  c.at_rest.store(true);
}

void render_thread(Control& c, RenderLane& lane, SessionFigures& out, const SessionSettings& set, int nice) {
  be_nice(nice);
  // The patient is published before the clock starts; the picture sink is made ready with it.
  lane.prepare();
  c.i_am_ready();
  const int64_t start_ns = c.wait_for_start();
  const RealClock clock(start_ns);  // a person sees by the wall's clock, however slowly the session's runs
  const PacedClock session(start_ns, c.held_ns, set.slow_motion.get());
  const int64_t period = int64_t(set.ticks_per_frame) * kDeviceTickNs;
  LaneTimes& t = out.render;
  int64_t due = set.first_tick * kDeviceTickNs + period;
  int64_t shown_sample = -1, drawn_ns = 0, drawn_before = 0, since = 0;  // drawn since about a second
  for (bool last = false; !last;) {
    last = c.stop_render.load();  // one more frame after the end: the patient at rest
    if (!last) clock.sleep_until_ns(due);
    const int64_t woke = clock.now_ns(), late = woke - due;
    if (!last && late > 0) {
      t.wake.add(late);
      if (late >= period) ++t.late;
    }
    const int64_t cpu = thread_cpu_ns();
    c.drawing.picture_begins(woke);
    const bool drew = lane.frame();
    const int64_t done = clock.now_ns();
    const int64_t pause = c.drawing.picture_ended(done, thread_cpu_ns() - cpu);
    const int64_t next = std::max(due + period, drew ? done + pause : done);
    if (!last) t.skipped += uint64_t((next - due) / period - 1);
    due = next;
    if (drew) {
      t.work.add(done - woke);
      ++t.ticks;
      drawn_ns += done - woke;
      if (set.gauges) {
        LaneGauges::set(set.gauges->frame_ns, done - woke);
        LaneGauges::set(set.gauges->frames, int64_t(t.ticks));
        const double loss = c.drawing.loss();
        LaneGauges::set(set.gauges->loss_permille, loss < 0 ? -1
                                                            : int64_t(1000 * loss * double(drawn_ns - drawn_before) /
                                                                      double(std::max<int64_t>(1, done - since))));
        if (done - since > 1'000'000'000) since = done, drawn_before = drawn_ns;
      }
      if (lane.sample_ns() != shown_sample) out.sample_to_frame.add(session.now_ns() - lane.sample_ns());
      shown_sample = lane.sample_ns();
    }
    if (!lane.open()) {  // nobody sees a further frame
      c.closed = c.stop_device = true;
      c.stop_render.wait(false);
      break;
    }
  }
  lane.finish();
}

/// The calling thread while the session runs: writes the recording, hears the window, looks out for the end.
void drive(Control& c, const SessionLanes& lanes, SessionFigures& out, const SessionSettings& set, int64_t start_ns,
           bool real_time, ScheduledThread& device_thread) {
  Recorder* const recorder = lanes.recorder;
  const RealClock clock(start_ns);
  bool told = !real_time;
  RecordingWatch recording;
  PaceWatch pace;
  PaceOverASecond slowed;
  SlowWatch slow_words;
  uint64_t skipped = 0;  // said so far
  const SlowedTime* const slow_motion = set.slow_motion.get();
  // Silence is counted as often as it was looked at: a machine that stood still is no silent thread.
  int64_t last_tick = -1, silent_ns = 0;
  const int64_t look_ns = (set.pump ? 4 : 10) * kNsPerMs;
  for (int64_t t = 0; !c.at_rest && !c.failed(); t += look_ns) {
    clock.sleep_until_ns(t);
    t = std::max(t, clock.now_ns());
    if (set.pump) set.pump();
    if (!set.hand_waits && set.say)
      if (const std::string words = pace.look(t / kNsPerMs, c.behind_ms.load()); !words.empty()) set.say(words);
    if (slow_motion && !c.device_ended) {
      const int64_t wall = t + set.first_tick * kDeviceTickNs;
      out.slowed_ns = wall - slow_motion->at(wall);
      slowed.look(wall, wall - out.slowed_ns);
      out.slowest = slowed.slowest();
      if (set.gauges) LaneGauges::set(set.gauges->pace_permille, int64_t(1000 * slowed.pace()));
      std::string words = slow_words.look(t / kNsPerMs, slowed.pace());
      if (const uint64_t n = c.skipped.load(std::memory_order_relaxed); n != skipped && words.empty()) {
        words = fmt::format("slower than {:.1f} of real time would be needed: {} steps skipped so far",
                            double(SlowedTime::kLeast) / double(SlowedTime::kWhole), n);
        skipped = n;
      }
      if (!words.empty() && set.say) set.say(words);
    }
    if (const int64_t tick = c.tick.load(); tick != last_tick || told || set.hand_waits)
      last_tick = tick, silent_ns = 0;
    else if ((silent_ns += look_ns) > kSilentNs && !c.device_ended)
      give_up_real_time(c, c.device_id);
    if (c.device_gave_up && !told) {
      told = true;
      if (set.say) set.say("device thread: a tick took more than 50 ms; it goes on with ordinary scheduling");
    }
    if (recorder) {
      recorder->drain();
      if (const std::string words = recording.look(*recorder); !words.empty() && set.say) set.say(words);
      if (recorder->failed() && set.stop_when_recording_fails) out.interrupted = true;
    }
    if (set.interrupted && set.interrupted()) out.interrupted = true;
    if (set.progress) set.progress(c.tick.load());
    if (out.interrupted) {
      c.stop_device = true;
      device_thread.join();
      c.device_ended = true;
      c.stop_solver = true;
      return;
    }
  }
}

}  // namespace

std::string words_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "unknown exception";
  }
}

void fail_session(const std::string& where, const SessionFigures& figures) {
  const std::exception_ptr cause = std::current_exception();
  throw SessionFailure(where, words_of(cause), figures, cause);
}

SessionFigures run_realtime(SessionLanes lanes, const SessionSettings& set, const RealTimeSettings& rt,
                            const std::function<void(int64_t)>& before_start) {
  SessionFigures out;
  Control c;
  c.tick = c.step_tick = set.first_tick;
  DeviceLane& device = lanes.device;
  SolverLane& solver = lanes.solver;
  RenderLane& render = lanes.render;
  Recorder* const recorder = lanes.recorder;
  {
    Crew crew(c);
    try {
      // The first patient must be published before the render thread makes its sink ready.
      crew.solver.emplace(guarded(c, "solver thread", [&] { solver_thread(c, solver, out, set, rt.solver_budget); }));
      c.wait_until_ready(1);
      crew.render.emplace(guarded(c, "render thread", [&] { render_thread(c, render, out, set, rt.render_nice); }));
      c.wait_until_ready(2);
      crew.device.emplace(
          guarded(c, "device thread", [&] { device_thread(c, device, out.device, set, rt.fifo_priority); }));
      c.wait_until_ready(3);
      const int64_t start = RealClock::monotonic_ns() + 20 * kNsPerMs;
      if (before_start) before_start(start);
      if (set.say) set.say(c.scheduling);
      c.start(start - set.first_tick * kDeviceTickNs);
      drive(c, lanes, out, set, start, rt.fifo_priority > 0, *crew.device);
      crew.device->join();
      crew.solver->join();
    } catch (...) {
      c.fail("main thread");
    }
  }
  out.ticks = int64_t(out.device.ticks);
  out.last_tick = c.tick.load();
  out.duration_s = double(out.last_tick) * 1e-3;
  out.scheduling = c.scheduling;
  out.hand = set.hand_waits ? "waits" : set.slow_motion ? "slowed" : "live", out.waited_ns = c.held_ns.load();
  out.closed = c.closed;
  device.end_schedule();
  if (c.error) {
    if (recorder) recorder->cut_short();
    throw SessionFailure(c.where, words_of(c.error), out, c.error);
  }
  out.state_hash = solver.state_hash();
  if (recorder) recorder->finish(out.last_tick, out.state_hash);
  return out;
}

}  // namespace limberg
