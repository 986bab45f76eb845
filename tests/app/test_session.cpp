// The lanes together: lockstep is the same every time, a recording made of it replays to the same bits, real time loses
// nothing and ends at the same place, and the device thread takes no memory.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>

#include "app/session/as_recorded.h"
#include "app/session/clock.h"
#include "app/session/lockstep.h"
#include "app/session/pace_watch.h"
#include "app/session/realtime.h"
#include "app/session/workers_pool.h"
#include "devices/continued_source.h"
#include "devices/emulator.h"
#include "devices/force/force_source.h"
#include "devices/log_source.h"
#include "sim/base/error.h"
#include "tests/app/fake_patient.h"
#include "tests/app/malloc_counter.h"

namespace {
int threads_allowed = -1;  // so many may still be started; -1: any number
}

#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
extern "C" int pthread_create(pthread_t* id, const pthread_attr_t* attr, void* (*run)(void*), void* with) {
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto real = reinterpret_cast<Create>(dlsym(RTLD_NEXT, "pthread_create"));
  if (threads_allowed == 0) return EAGAIN;
  if (threads_allowed > 0) --threads_allowed;
  return real(id, attr, run, with);
}
#endif

namespace limberg {
namespace test_session {

std::vector<Command> operation() {
  return {Incise{{{-10, -5}, {10, -5}}, 4, 90},
          Stage{"cut"},
          SetHook{1, {3, 4}},
          MoveHook{1, {6, 8, 5}, 0.8},
          Stage{"pulled"},
          Incise{{{-8, 6}, {-8, 12}}, 10, 90},  // too deep: refused
          ReleaseHook{1},
          SetHook{2, {-6, 0}},
          MoveHook{2, {-9, 0, 4}, 0.5},
          Stage{"end"}};
}

/// Notes what it is shown.
struct Notes final : PictureSink {
  std::vector<std::string> stages;
  int frames = 0;
  uint64_t last_step = 0;
  bool went_back = false;
  int fails_at_frame = -1;
  int64_t closes_at_ns = -1;
  bool wants_frame() override { return fails_at_frame >= 0 || closes_at_ns >= 0; }
  bool open() const override { return closes_at_ns < 0 || RealClock::monotonic_ns() < closes_at_ns; }
  void frame(const Snapshot& s, const ToolState&) override {
    if (++frames == fails_at_frame) throw std::runtime_error("broken screen");
    went_back |= s.step < last_step;
    last_step = s.step;
  }
  void stage(const std::string& name, const Snapshot&) override { stages.push_back(name); }
};

struct Rig {
  explicit Rig(std::unique_ptr<Source> source, Workers* workers = nullptr, bool record = false, bool schedule = false)
      : patient(workers),
        front(Calibration{}),
        device(front, *channels, record, schedule),
        solver(patient, *channels, settings(schedule)),
        render(*channels, &notes, true) {
    front.add(std::move(source));
  }
  static SolverSettings settings(bool schedule) {
    SolverSettings s;
    s.schedule = schedule;
    s.hash_every = 10;
    s.step.adopt_when_ready = schedule;
    s.step.max_iterations = 6;
    s.step.tolerance = 1e-9;
    return s;
  }
  SessionLanes lanes(Recorder* r = nullptr) { return {device, solver, render, r}; }

  FakePatient patient;
  std::unique_ptr<Channels> channels = std::make_unique<Channels>();
  Notes notes;
  DeviceFrontEnd front;
  DeviceLane device;
  SolverLane solver;
  RenderLane render;
};

std::unique_ptr<Source> surgeon(uint64_t seed = 3) {
  SurgeonSettings s;
  s.seed = seed;
  return std::make_unique<EmulatedSurgeon>(operation(), s);
}

SessionSettings quick() {
  SessionSettings s;
  s.settle_residual = 1e-8;
  return s;
}

std::string temporary(const char* name) {
  return (std::filesystem::temp_directory_path() / (std::string("limberg-") + std::to_string(getpid()) + name))
      .string();
}

TEST(Lockstep, CarriesOutTheScript) {
  Rig rig(surgeon());
  const SessionFigures f = run_lockstep(rig.lanes(), quick());
  EXPECT_EQ(rig.notes.stages, (std::vector<std::string>{"cut", "pulled", "end"}));
  ASSERT_EQ(rig.solver.refused().size(), 1u);
  EXPECT_EQ(rig.solver.refused()[0].command, "incise");
  ASSERT_EQ(rig.solver.stages().size(), 3u);
  for (const StageRow& s : rig.solver.stages()) EXPECT_TRUE(s.shown.topology);
  EXPECT_EQ(rig.patient.hooks(), 1u);  // the second one stands
  EXPECT_EQ(rig.solver.event_gaps(), 0);
  EXPECT_EQ(rig.device.events_lost(), 0u);
  EXPECT_EQ(uint64_t(f.ticks), uint64_t(f.last_tick) + 1);
  EXPECT_NEAR(double(rig.solver.steps()), double(f.ticks) / 16 + f.settle_steps, 1.0);
  EXPECT_GT(rig.notes.frames, 10);
  EXPECT_LE(rig.notes.frames, (f.ticks - 1) / 33 + 2);  // one at tick 0, one at the end
  EXPECT_FALSE(rig.notes.went_back);
  // The hook that was put down stands where the hand left it: tracker noise and tremor are tenths of a millimetre.
  Snapshot s;
  rig.patient.fill(s);
  EXPECT_NEAR((s.hooks[0].handle_mm - Vec3f(-9, 0, 4)).norm(), 0, 1.0);
}

TEST(Lockstep, SameBitsEveryTimeAndWithAnyWorkers) {
  uint64_t hash = 0;
  std::vector<Checkpoint> checkpoints;
  for (const int workers : {0, 1, 2, 3}) {
    const std::unique_ptr<Workers> w = workers ? std::make_unique<WorkersPool>(workers) : nullptr;
    Rig rig(surgeon(), w.get());
    const SessionFigures f = run_lockstep(rig.lanes(), quick());
    if (hash == 0) hash = f.state_hash, checkpoints = f.checkpoints;
    EXPECT_EQ(f.state_hash, hash) << workers;
    ASSERT_EQ(f.checkpoints.size(), checkpoints.size());
    for (size_t i = 0; i < checkpoints.size(); ++i) EXPECT_EQ(f.checkpoints[i].hash, checkpoints[i].hash);
  }
  Rig other(surgeon(4));
  EXPECT_NE(run_lockstep(other.lanes(), quick()).state_hash, hash);  // the hash sees another tremor
}

TEST(Lockstep, ARecordingReplaysToTheSameBits) {
  const std::string file = temporary("replay.lcm");
  uint64_t hash = 0;
  {
    Rig rig(surgeon(), nullptr, true);
    Recorder recorder(*rig.channels, file, SessionInfo{}, {}, true);
    hash = run_lockstep(rig.lanes(&recorder), quick()).state_hash;
    EXPECT_FALSE(recorder.failed()) << recorder.error();
    EXPECT_GT(recorder.samples(), 100);
  }
  Recording rec = read_recording(file);
  std::filesystem::remove(file);
  EXPECT_EQ(rec.damage.total(), 0) << rec.damage.first_message;
  ASSERT_TRUE(rec.end.has_value());
  ASSERT_GT(rec.checkpoints.size(), 3u);
  Rig again(std::make_unique<LogSource>(rec.samples));
  SessionSettings set = quick();
  set.end_tick = rec.end->tick;
  const SessionFigures f = run_lockstep(again.lanes(), set);
  EXPECT_EQ(f.state_hash, hash);
  ASSERT_EQ(f.checkpoints.size(), rec.checkpoints.size() + 1);
  for (size_t i = 0; i < rec.checkpoints.size(); ++i) {
    EXPECT_EQ(f.checkpoints[i].tick, rec.checkpoints[i].tick);
    EXPECT_EQ(f.checkpoints[i].hash, rec.checkpoints[i].hash);
  }
  EXPECT_EQ(f.checkpoints.back().hash, rec.end->hash);
}

TEST(Lockstep, AFullDiskEndsTheRecordingAndSaysSo) {
  Rig rig(surgeon(), nullptr, true);
  std::unique_ptr<Recorder> recorder;
  try {
    recorder = std::make_unique<Recorder>(*rig.channels, "/dev/full", SessionInfo{}, std::vector<Blob>{}, true);
  } catch (const InputError&) {
    return;  // refused at once: just as well
  }
  SessionSettings set = quick();
  set.stop_when_recording_fails = true;
  run_lockstep(rig.lanes(recorder.get()), set);
  EXPECT_TRUE(recorder->failed());
  EXPECT_NE(recorder->error().find("No space"), std::string::npos) << recorder->error();
}

TEST(Lockstep, EndsWhenInterrupted) {
  Rig rig(surgeon());
  SessionSettings set = quick();
  int asked = 0;
  set.interrupted = [&] { return ++asked > 5; };
  const SessionFigures f = run_lockstep(rig.lanes(), set);
  EXPECT_TRUE(f.interrupted);
  EXPECT_LT(f.ticks, 1000);
}

TEST(Lockstep, TheDeviceLaneTakesNoMemoryWhateverIsCut) {
  if (!malloc_counter::works()) GTEST_SKIP() << "malloc is taken by a sanitizer";
  Recording rec;
  {
    const std::string file = temporary("quiet.lcm");
    Rig rig(surgeon(), nullptr, true);
    Recorder recorder(*rig.channels, file, SessionInfo{}, {}, true);
    run_lockstep(rig.lanes(&recorder), quick());
    rec = read_recording(file);
    std::filesystem::remove(file);
  }
  Rig rig(std::make_unique<LogSource>(rec.samples), nullptr, true);
  rig.solver.start();
  uint64_t taken = 0, freed = 0;
  for (int64_t tick = 0; tick <= rec.end->tick; ++tick) {
    const uint64_t count = malloc_counter::count(), frees = malloc_counter::frees();
    rig.device.tick(tick);
    taken += malloc_counter::count() - count, freed += malloc_counter::frees() - frees;
    if (tick % 16 == 0) rig.solver.step(tick);
    for (Sample x; rig.channels->samples.pop(x);) {
    }
  }
  EXPECT_GT(rig.channels->patient_to_device.reading().snapshot.topology_version, 1u) << "something was cut";
  EXPECT_EQ(taken, 0u);
  EXPECT_EQ(freed, 0u);
}

TEST(MallocCounter, SeesAnAllocation) {
  if (!malloc_counter::works()) GTEST_SKIP() << "malloc is taken by a sanitizer";
  const uint64_t before = malloc_counter::count();
  const std::unique_ptr<Rig> rig = std::make_unique<Rig>(surgeon());
  EXPECT_GT(malloc_counter::count(), before);
}

TEST(RealTime, LosesNothingAndEndsWhereLockstepDoes) {
  // A short recording, so that the test takes its three or four seconds and no more.
  const std::vector<Command> script{SetHook{1, {3, 4}}, MoveHook{1, {6, 8, 5}, 0.5}, Stage{"pulled"}};
  SurgeonSettings ss;
  ss.dropouts_per_s = 0, ss.settle_s = 0.1, ss.start_s = 0.1, ss.carry_mm_s = 200;
  const std::string file = temporary("rt.lcm");
  std::vector<Vec3> at_end;
  {
    Rig rig(std::make_unique<EmulatedSurgeon>(script, ss), nullptr, true);
    Recorder recorder(*rig.channels, file, SessionInfo{}, {}, true);
    run_lockstep(rig.lanes(&recorder), quick());
    at_end = rig.patient.x_mm();
  }
  Recording rec = read_recording(file);
  Rig rig(std::make_unique<LogSource>(rec.samples), nullptr, true);
  SessionSettings set = quick();
  set.end_tick = rec.end->tick;
  std::string said;
  set.say = [&](const std::string& s) { said += s; };
  const std::string copy = temporary("rt2.lcm");
  int64_t start_ns = 0;
  SessionFigures f;
  {
    Recorder recorder(*rig.channels, copy, SessionInfo{}, {}, true);
    f = run_realtime(rig.lanes(&recorder), set, {}, [&](int64_t t) { start_ns = t; });
    EXPECT_FALSE(recorder.failed()) << recorder.error();
  }
  EXPECT_GT(start_ns, 0);
  EXPECT_NE(said.find("device thread:"), std::string::npos);
  EXPECT_EQ(rig.notes.stages, std::vector<std::string>{"pulled"});
  EXPECT_EQ(rig.device.events_lost(), 0u);
  EXPECT_EQ(rig.solver.event_gaps(), 0);
  EXPECT_EQ(f.last_tick, rec.end->tick);
  EXPECT_GT(f.device.ticks + f.device.skipped, uint64_t(rec.end->tick) * 9 / 10);
  double worst = 0;
  for (size_t i = 0; i < at_end.size(); ++i) worst = std::max(worst, (rig.patient.x_mm()[i] - at_end[i]).norm());
  EXPECT_LT(worst, 0.2);  // the filter sees other ticks, the hand ends at the same place
  const Recording second = read_recording(copy);
  EXPECT_EQ(second.samples.size(), rec.samples.size());  // every sample as received
  std::filesystem::remove(file), std::filesystem::remove(copy);
}

/// A live session of some two seconds, recorded: a cut, a hook, and a clock that stops every third step early.
Recording live_recording(const std::string& file, uint64_t& hash, int64_t* early = nullptr) {
  const std::vector<Command> script{Incise{{{-4, -5}, {0, -5}}, 4, 90}, SetHook{1, {3, 4}}, MoveHook{1, {6, 8, 5}, 0.4},
                                    Stage{"pulled"}};
  SurgeonSettings ss;
  ss.settle_s = 0.05, ss.start_s = 0.1, ss.carry_mm_s = 300, ss.corner_pause_s = 0.05;
  Rig rig(std::make_unique<EmulatedSurgeon>(script, ss), nullptr, true, true);
  Recorder recorder(*rig.channels, file, SessionInfo{}, {}, true);
  const SessionFigures f = run_realtime(rig.lanes(&recorder), quick(), {.solver_budget = 0});
  EXPECT_FALSE(recorder.failed()) << recorder.error();
  hash = f.state_hash;
  Recording rec = read_recording(file);
  EXPECT_EQ(rec.damage.total(), 0) << rec.damage.first_message;
  EXPECT_TRUE(rec.schedule.usable());
  EXPECT_EQ(rec.schedule.solver.size(), f.solver.ticks);
  EXPECT_TRUE(rec.end && rec.end->hash == hash);
  if (early)
    for (const SolverTake& t : rec.schedule.solver) *early += t.stop_at > 0;
  return rec;
}

SessionFigures again(const Recording& rec, const LiveSchedule& schedule, Workers* workers = nullptr) {
  auto source = std::make_unique<TakenSource>(rec.samples);
  TakenSource& taken = *source;
  Rig rig(std::move(source), workers);
  SessionSettings set = quick();
  if (rec.end) set.settle_steps = 0;
  return run_as_recorded(rig.lanes(), set, schedule, taken);
}

TEST(AsRecorded, ALiveSessionReplaysToTheSameBits) {
  const std::string file = temporary("live.lcm");
  uint64_t hash = 0;
  int64_t early = 0;
  const Recording rec = live_recording(file, hash, &early);
  EXPECT_GT(early, 10);  // a budget of nothing: whatever is not done after one iteration is cut short
  WorkersPool two(2);
  for (Workers* w : {static_cast<Workers*>(nullptr), static_cast<Workers*>(&two)}) {
    const SessionFigures f = again(rec, rec.schedule, w);
    EXPECT_EQ(f.state_hash, hash);
    EXPECT_GT(f.hashes_compared, 5);
    EXPECT_EQ(f.hashes_equal, f.hashes_compared);
    EXPECT_EQ(f.first_difference_tick, -1);
  }
  std::filesystem::remove(file);
}

TEST(AsRecorded, EachColumnOfTheScheduleCounts) {
  const std::string file = temporary("live2.lcm");
  uint64_t hash = 0;
  const Recording rec = live_recording(file, hash);
  std::filesystem::remove(file);
  const auto differs = [&](const LiveSchedule& s) {
    const SessionFigures f = again(rec, s);
    return f.state_hash != hash || f.hashes_equal != f.hashes_compared || f.first_difference_tick >= 0;
  };
  LiveSchedule s = rec.schedule;
  ASSERT_FALSE(differs(s));
  size_t at = 0;  // a step within the hook's way that was cut short
  for (size_t i = 0; i < s.solver.size(); ++i)
    if (s.solver[i].stop_at == 1 && s.solver[i].events > 0) at = i;
  ASSERT_GT(at, 0u);
  s.solver[at].stop_at = 3;
  EXPECT_TRUE(differs(s)) << "the clock's stop";
  s = rec.schedule;
  for (SolverTake& t : s.solver) t.hand_tick = std::min<int64_t>(t.hand_tick, 400);
  EXPECT_TRUE(differs(s)) << "the hand";
  s = rec.schedule;
  for (size_t i = 0; i + 1 < s.device.size(); ++i)
    if (s.device[i].samples > 0) std::swap(s.device[i].samples, s.device[i + 1].samples);
  EXPECT_TRUE(differs(s)) << "the samples of a tick";
}

TEST(AsRecorded, AKilledSessionLosesLessThanASecondAndReplays) {
  const std::string file = temporary("killed.lcm");
  uint64_t hash = 0;
  const Recording whole = live_recording(file, hash);
  std::filesystem::remove(file);
  // Written anew from what the threads passed on, and looked at as it stands on the disk when the program is killed:
  // what the writer still holds is lost.
  RecordingWriter w;
  w.open(file, SessionInfo{}, {}, true);
  size_t run = 0, step = 0, sample = 0;
  const int64_t killed = whole.end->tick * 3 / 4;
  for (int64_t tick = 0; tick < killed; ++tick) {
    for (; run < whole.schedule.device.size() &&
           whole.schedule.device[run].tick + whole.schedule.device[run].count - 1 <= tick;
         ++run) {
      for (int32_t k = 0; k < whole.schedule.device[run].samples; ++k) w.on_sample(whole.samples[sample++]);
      w.schedule(whole.schedule.device[run]);
    }
    for (; step < whole.schedule.solver.size() && whole.schedule.solver[step].tick <= tick; ++step)
      w.schedule(whole.schedule.solver[step]);
  }
  const std::string copy = temporary("killed-copy.lcm");
  std::filesystem::copy_file(file, copy);
  std::filesystem::resize_file(copy, std::filesystem::file_size(copy) - 11);  // the last event is torn
  const Recording rec = read_recording(copy);
  std::filesystem::remove(file), std::filesystem::remove(copy);
  EXPECT_FALSE(rec.end);
  EXPECT_EQ(rec.damage.total(), 1);
  ASSERT_TRUE(rec.schedule.usable());
  EXPECT_GT(rec.schedule.solver.back().tick, killed - 1000);
  const SessionFigures f = again(rec, rec.schedule);
  EXPECT_GT(f.hashes_compared, 2);
  EXPECT_EQ(f.hashes_equal, f.hashes_compared);
  EXPECT_EQ(f.first_difference_tick, -1);
}

/// As much of a recording as a killed session leaves, done again and gone on with; what is recorded of both parts.
Recording gone_on(const std::vector<Sample>& samples, const LiveSchedule& schedule, int64_t even_end_tick,
                  uint64_t& hash) {
  std::unique_ptr<Source> source;
  TakenSource* taken = nullptr;
  if (schedule.usable()) {
    auto t = std::make_unique<TakenSource>(samples);
    taken = t.get(), source = std::move(t);
  } else {
    source = std::make_unique<LogSource>(samples);
  }
  Rig rig(std::move(source), nullptr, true, true);
  const std::string file = temporary("on.lcm");
  Recorder recorder(*rig.channels, file, SessionInfo{}, {}, true);
  SessionSettings set = quick();
  set.goes_on = true, set.end_tick = even_end_tick;
  const SessionFigures before =
      taken ? run_as_recorded(rig.lanes(&recorder), set, schedule, *taken) : run_lockstep(rig.lanes(&recorder), set);
  set = quick();
  set.first_tick = (before.last_tick / set.ticks_per_solver_step + 1) * set.ticks_per_solver_step;
  const auto earlier = std::make_shared<EarlierPart>(samples, set.first_tick * kDeviceTickNs);
  rig.front.add(std::make_unique<LogSource>(earlier->let_go()));
  SurgeonSettings ss;
  ss.settle_s = 0.05, ss.start_s = 0.1, ss.carry_mm_s = 300, ss.corner_pause_s = 0.05;
  rig.front.add(std::make_unique<ContinuedSource>(
      std::make_unique<EmulatedSurgeon>(std::vector<Command>{SetHook{2, {-6, 4}}, MoveHook{2, {-9, 8, 4}, 0.3}}, ss),
      earlier));
  const SessionFigures f = run_realtime(rig.lanes(&recorder), set, {.solver_budget = 0});
  EXPECT_FALSE(recorder.failed()) << recorder.error();
  EXPECT_GT(f.last_tick, set.first_tick + 300);
  hash = f.state_hash;
  Recording rec = read_recording(file);
  std::filesystem::remove(file);
  return rec;
}

TEST(AsRecorded, ASessionThatWasCutOffGoesOnAndReplaysAsOne) {
  const std::string file = temporary("cut.lcm");
  uint64_t hash = 0;
  const Recording whole = live_recording(file, hash);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) * 2 / 3);
  const Recording cut = read_recording(file);
  std::filesystem::remove(file);
  ASSERT_TRUE(cut.schedule.usable());
  std::vector<Sample> samples = cut.samples;
  size_t taken = 0;
  for (const DeviceRun& r : cut.schedule.device) taken += size_t(r.samples);
  samples.resize(taken);
  for (const bool as_it_was : {true, false}) {
    const int64_t end_tick = time_of(samples.back()) / kDeviceTickNs + 1;
    const Recording rec = gone_on(samples, as_it_was ? cut.schedule : LiveSchedule{}, end_tick, hash);
    EXPECT_EQ(rec.damage.total(), 0) << rec.damage.first_message;
    ASSERT_TRUE(rec.end);
    EXPECT_GT(rec.samples.size(), samples.size() + 20);
    EXPECT_GT(rec.end->tick, end_tick + 300);
    const SessionFigures f = again(rec, rec.schedule);
    EXPECT_EQ(f.state_hash, hash) << as_it_was;
    EXPECT_EQ(f.state_hash, rec.end->hash);
    EXPECT_GT(f.hashes_compared, 5);
    EXPECT_EQ(f.hashes_equal, f.hashes_compared);
    EXPECT_EQ(f.first_difference_tick, -1);
  }
}

TEST(WorkersPool, AMachineThatGivesNoMoreThreadsHasFewerWorkers) {
  if (!malloc_counter::works()) GTEST_SKIP() << "a sanitizer starts threads itself";
  for (const int threads : {0, 2}) {
    threads_allowed = threads;
    WorkersPool pool(5);
    threads_allowed = -1;
    EXPECT_EQ(pool.count(), threads + 1);
    std::atomic<int> sum{0};
    pool.parallel_for(100, 3, [&](size_t a, size_t b) { sum += int(b - a); });
    EXPECT_EQ(sum, 100);
  }
}

TEST(AsRecorded, AScheduleWithAMissingRowIsNotTakenForWhole) {
  const std::string file = temporary("gap.lcm");
  RecordingWriter w;
  w.open(file, SessionInfo{}, {}, true);
  w.on_sample(StylusSample{});
  w.schedule(DeviceRun{0, 0, 10, 1});
  w.schedule(SolverTake{1, 5, 4, 0});
  w.schedule(SolverTake{3, 9, 8, 0});  // the second is missing
  w.finish(10, 1);
  const Recording rec = read_recording(file);
  EXPECT_TRUE(rec.schedule.broken);
  EXPECT_FALSE(rec.schedule.usable());
  EXPECT_EQ(rec.samples.size(), 1u);
  std::filesystem::remove(file);
}

TEST(RealTime, AForceDeviceFeelsThePatientOfTheSolverThread) {
  Rig rig(surgeon());
  rig.channels->press = std::make_shared<PressLine>();
  SimulatedHand hand;
  hand.target = [](double t) { return Vec3(8, 8, 6 - 9 * std::min(1.0, 2 * t)); };
  auto source = std::make_unique<ForceSource>(std::make_unique<SimulatedForceDevice>(hand), ForceSourceSettings{},
                                              rig.channels->press);
  const ForceSource& force = *source;
  rig.front.add(std::move(source));
  SessionSettings set = quick();
  set.end_tick = 2500;
  run_realtime(rig.lanes(), set, {});
  EXPECT_GT(force.answers(), 5);
  EXPECT_EQ(force.model().stiffness_N_mm, 0.3);
  EXPECT_GT(force.loop().state().force_N.z(), 0);
}

/// A device that is there for ever, or fails at a given time.
struct Endless final : Source {
  int64_t fails_at_ns = -1;
  explicit Endless(int64_t fails_at_ns_ = -1) : fails_at_ns(fails_at_ns_) {}
  void poll(int64_t now_ns, SampleSink& sink) override {
    if (fails_at_ns >= 0 && now_ns >= fails_at_ns) throw std::runtime_error("broken device");
    StylusSample s;
    s.device_id = 7, s.seq = seq++, s.t_ns = now_ns, s.tip_mm = Vec3(0, 0, 40);
    sink.on_sample(s);
  }
  bool done() const override { return false; }
  SourceCounts counts() const override { return {}; }
  int64_t seq = 0;
};

/// Runs a session that has to fail; what it says of it, and how many samples its recording holds.
std::string failure_of(Rig& rig, const SessionSettings& set, size_t* recorded = nullptr) {
  const std::string file = temporary("failed.lcm");
  std::string said = "nothing failed";
  {
    Recorder recorder(*rig.channels, file, SessionInfo{}, {}, true);
    try {
      run_realtime(rig.lanes(&recorder), set, {});
    } catch (const SessionFailure& e) {
      said = e.what();
      EXPECT_TRUE(e.cause);
      EXPECT_GE(e.figures.last_tick, 0);
    }
  }
  if (recorded) {
    const Recording rec = read_recording(file);
    EXPECT_EQ(rec.damage.total(), 0) << rec.damage.first_message;
    EXPECT_FALSE(rec.end) << "a session that failed has no end";
    *recorded = rec.samples.size();
    if (*recorded > 0) {
      EXPECT_TRUE(rec.schedule.usable()) << "it can be done again";
    }
  }
  std::filesystem::remove(file);
  return said;
}

TEST(Failure, OfADeviceEndsTheSessionAndKeepsItsRecording) {
  Rig rig(std::make_unique<Endless>(300'000'000), nullptr, true, true);
  size_t recorded = 0;
  EXPECT_EQ(failure_of(rig, quick(), &recorded), "device thread: broken device");
  EXPECT_GT(recorded, 100u);
}

TEST(Failure, OfThePatientEndsTheSessionAndKeepsItsRecording) {
  Rig rig(std::make_unique<Endless>(), nullptr, true, true);
  rig.patient.fail_at_step(20);
  size_t recorded = 0;
  EXPECT_EQ(failure_of(rig, quick(), &recorded), "solver thread: broken patient");
  EXPECT_GT(recorded, 100u);
}

TEST(Failure, OfThePictureEndsTheSessionAndKeepsItsRecording) {
  Rig rig(std::make_unique<Endless>(), nullptr, true, true);
  rig.notes.fails_at_frame = 5;
  size_t recorded = 0;
  EXPECT_EQ(failure_of(rig, quick(), &recorded), "render thread: broken screen");
  EXPECT_GT(recorded, 50u);
}

// What the calling thread is asked to do may fail as well: the others are told to end, and nobody waits for ever.
TEST(Failure, OfTheCallersOwnThreadEndsTheSession) {
  for (const bool at_start : {true, false}) {
    Rig rig(std::make_unique<Endless>(), nullptr, true, true);
    SessionSettings set = quick();
    int calls = 0;
    if (at_start)
      set.say = [](const std::string&) { throw std::runtime_error("broken terminal"); };
    else
      set.pump = [&] {
        if (++calls > 50) throw std::runtime_error("broken window");
      };
    size_t recorded = 0;
    EXPECT_EQ(failure_of(rig, set, &recorded),
              at_start ? "main thread: broken terminal" : "main thread: broken window");
    EXPECT_EQ(recorded > 0, !at_start);
  }
}

TEST(Failure, OfStartingAThreadEndsTheOthers) {
  if (!malloc_counter::works()) GTEST_SKIP() << "a sanitizer starts threads itself";
  for (const int threads : {0, 1, 2}) {
    Rig rig(std::make_unique<Endless>());
    threads_allowed = threads;
    const std::string said = failure_of(rig, quick());
    threads_allowed = -1;
    EXPECT_EQ(said.find("main thread: starting a thread"), 0u) << said;
  }
}

// Nobody looks any more: the patient need not come to rest, unless a judge wants to see it.
TEST(RealTime, EndsAtOnceWhenTheWindowIsClosed) {
  for (const bool judged : {false, true}) {
    Rig rig(std::make_unique<Endless>());
    rig.patient.keep_busy();
    rig.notes.closes_at_ns = RealClock::monotonic_ns() + 300'000'000;
    SessionSettings set = quick();
    set.settle_steps = 40, set.settle_when_closed = judged;
    const SessionFigures f = run_realtime(rig.lanes(), set, {});
    EXPECT_TRUE(f.closed);
    EXPECT_FALSE(f.interrupted);
    if (judged)
      EXPECT_EQ(f.settle_steps, 40);
    else
      EXPECT_LE(f.settle_steps, 2);
  }
}

TEST(PaceWatch, SaysOnceAndNotAtEveryFlicker) {
  PaceWatch w;
  std::vector<std::pair<int64_t, std::string>> said;
  const auto lasts = [&](int64_t from, int64_t to, auto&& behind) {
    for (int64_t t = from; t < to; t += 10)
      if (const std::string s = w.look(t, behind(t)); !s.empty()) said.emplace_back(t, s);
  };
  lasts(0, 3000, [](int64_t t) { return t % 100 == 0 ? 120 : 20; });  // a long step now and then
  EXPECT_TRUE(said.empty());
  lasts(3000, 6000, [](int64_t) { return 90; });
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].first, 3200);
  EXPECT_EQ(said[0].second, "the patient is 90 ms behind your hand");
  lasts(6000, 8000, [](int64_t t) { return t % 200 < 100 ? 80 : 60; });  // about the limit
  EXPECT_EQ(said.size(), 1u);
  lasts(8000, 9000, [](int64_t) { return 400; });
  ASSERT_EQ(said.size(), 2u) << "twice as far: said again";
  EXPECT_EQ(said[1].second, "the patient is 400 ms behind your hand");
  lasts(9000, 12000, [](int64_t) { return 16; });
  ASSERT_EQ(said.size(), 3u);
  EXPECT_EQ(said[2].second, "the patient keeps up with your hand again");
  EXPECT_NEAR(double(said[2].first), 10000, 20);
}

// A patient whose steps take three periods: a recorded hand waits for it, a live one is told.
TEST(RealTime, AHandThatWaitsLosesNoStepAndALiveOneIsTold) {
  for (const bool waits : {true, false}) {
    Rig rig(surgeon());
    rig.patient.take_time(waits ? 48'000'000 : 110'000'000);
    SessionSettings set = quick();
    set.hand_waits = waits, set.settle_steps = 1, set.end_tick = 1500;
    std::string said;
    set.say = [&](const std::string& line) { said += line + "\n"; };
    const SessionFigures f = run_realtime(rig.lanes(), set, {});
    EXPECT_EQ(f.hand, waits ? "waits" : "live");
    const double age_ms = double(f.device.age.percentile_ns(0.99)) * 1e-6;
    if (waits) {
      EXPECT_EQ(f.solver.skipped, 0u);
      EXPECT_EQ(rig.patient.out_of_time(), 0) << "a step takes all its iterations: the end hangs on no machine";
      EXPECT_NEAR(double(rig.solver.steps()), 1500.0 / 16, 4);
      EXPECT_GT(f.waited_ns, 1'500'000'000);  // 94 steps, each 32 ms too long
      EXPECT_LE(age_ms, 33) << "the hand is at most two periods ahead";
      EXPECT_EQ(said.find("behind your hand"), std::string::npos) << said;
    } else {
      EXPECT_GT(f.solver.skipped, 50u);
      EXPECT_GT(rig.patient.out_of_time(), 10);
      EXPECT_EQ(f.waited_ns, 0);
      EXPECT_GT(age_ms, 75);
      EXPECT_NE(said.find("ms behind your hand"), std::string::npos) << said;
    }
  }
}

// Replayed on a machine with time to spare, such a session tells what it was like when it was recorded.
TEST(AsRecorded, WhatALiveHandHadToBearIsToldByItsReplay) {
  const std::string file = temporary("slow.lcm");
  SessionFigures then;
  {
    Rig rig(surgeon(), nullptr, false, true);
    rig.patient.take_time(110'000'000);
    Recorder recorder(*rig.channels, file, SessionInfo{}, {}, true);
    SessionSettings set = quick();
    set.settle_steps = 1, set.end_tick = 1500;
    then = run_realtime(rig.lanes(&recorder), set, {});
    ASSERT_FALSE(recorder.failed()) << recorder.error();
  }
  const Recording rec = read_recording(file);
  std::filesystem::remove(file);
  ASSERT_TRUE(rec.schedule.usable());
  ASSERT_GT(then.solver.skipped, 50u);
  const SessionFigures now = again(rec, rec.schedule);
  const auto skipped = double(then.solver.skipped);
  // Periods are counted from the ticks of its steps, which stand still once the hand has left: what the step that it
  // leaves in and the one that settles take is not told.
  EXPECT_LE(double(now.solver.skipped), skipped);
  EXPECT_GE(double(now.solver.skipped), skipped - 2 * std::ceil(double(then.solver.work.max_ns()) / 16e6));
  EXPECT_GT(double(now.device.age.percentile_ns(0.99)) * 1e-6, 75);
}

/// A stylus with a clock of its own, as a receiving thread has it, read as often as the session asks.
struct Stamped final : Source {
  std::shared_ptr<SlowedTime> slowed;
  std::optional<SourceTime> time;
  int64_t seq = 0, last_ns = -1, off_ns = 0;
  bool grows = true;
  explicit Stamped(std::shared_ptr<SlowedTime> s) : slowed(std::move(s)) {}
  void poll(int64_t now_ns, SampleSink& sink) override {
    StylusSample s;
    s.device_id = 7, s.seq = seq++, s.tip_mm = Vec3(0, 0, 20 + 0.01 * double(seq % 100));
    s.t_ns = time->stamp_ns(time->wall_ns(RealClock::monotonic_ns()));
    off_ns = std::max(off_ns, std::abs(s.t_ns - now_ns));
    grows &= s.t_ns > last_ns;
    last_ns = s.t_ns;
    sink.on_sample(s);
  }
  bool done() const override { return false; }
  SourceCounts counts() const override { return {seq, 0, 0}; }
};

// A patient whose steps take three periods, and a live hand in slow motion: no step is lost, the session lasts longer
// by the wall's clock, stamps are of the session's, and the recording has it all.
TEST(RealTime, InSlowMotionALiveHandLosesNoStepAndItsRecordingReplays) {
  const std::string file = temporary("slowed.lcm");
  const auto slowed = std::make_shared<SlowedTime>();
  auto source = std::make_unique<Stamped>(slowed);
  Stamped& stylus = *source;
  SessionFigures then;
  uint64_t steps = 0;
  size_t samples = 0;
  std::string said;
  {
    Rig rig(std::move(source), nullptr, true, true);
    rig.patient.take_time(48'000'000);
    Recorder recorder(*rig.channels, file, SessionInfo{}, {}, true);
    SessionSettings set = quick();
    set.slow_motion = slowed, set.settle_steps = 1, set.end_tick = 1500;
    set.say = [&](const std::string& line) { said += line + "\n"; };
    const int64_t began = RealClock::monotonic_ns();
    then = run_realtime(rig.lanes(&recorder), set, {}, [&](int64_t start) { stylus.time.emplace(start, slowed); });
    EXPECT_GT(RealClock::monotonic_ns() - began, 3'800'000'000) << "94 steps of 48 ms";
    ASSERT_FALSE(recorder.failed()) << recorder.error();
    steps = rig.solver.steps(), samples = size_t(stylus.seq);
    EXPECT_LT(double(stylus.off_ns) * 1e-6, 100) << "the wall's stamps would be 3 s off";
    EXPECT_TRUE(stylus.grows);
  }
  EXPECT_EQ(then.hand, "slowed");
  EXPECT_EQ(then.solver.skipped, 0u);
  EXPECT_NEAR(double(steps), 1500.0 / 16, 6);
  EXPECT_GT(then.slowed_ns, 2'300'000'000);
  EXPECT_LT(then.slowest, 0.4);
  EXPECT_LT(double(then.device.age.percentile_ns(0.99)) * 1e-6, 75);
  EXPECT_NE(said.find("slowed: 0."), std::string::npos) << said;
  const Recording rec = read_recording(file);
  std::filesystem::remove(file);
  EXPECT_EQ(rec.damage.total(), 0) << rec.damage.first_message;
  ASSERT_TRUE(rec.schedule.usable());
  EXPECT_EQ(rec.samples.size(), samples);
  const SessionFigures now = again(rec, rec.schedule);
  EXPECT_EQ(now.state_hash, then.state_hash);
  EXPECT_GT(now.hashes_compared, 5);
  EXPECT_EQ(now.hashes_equal, now.hashes_compared);
  EXPECT_EQ(now.solver.skipped, 0u) << "a replay counts periods by the ticks of the steps";
}

TEST(RealTime, BelowTheLeastPaceSlowMotionSkipsAndSaysSo) {
  const auto slowed = std::make_shared<SlowedTime>();
  Rig rig(surgeon());
  rig.patient.take_time(240'000'000);
  SessionSettings set = quick();
  set.slow_motion = slowed, set.settle_steps = 1, set.end_tick = 700;
  std::string said;
  set.say = [&](const std::string& line) { said += line + "\n"; };
  const SessionFigures f = run_realtime(rig.lanes(), set, {});
  EXPECT_GT(f.solver.skipped, 10u);
  EXPECT_NE(said.find("steps skipped so far"), std::string::npos) << said;
  EXPECT_NE(said.find("slowed: 0.2 of real time"), std::string::npos) << said;
}

// The hand aimed at skin as it was shown; a long step has moved it since.
TEST(SolverLane, AStitchIsNotPlacedOnSkinThatIsNotWhereItWasShown) {
  const auto stitch = [](double a_away_mm, double b_away_mm) {
    Rig rig(std::make_unique<Endless>());
    rig.solver.start();
    rig.solver.step(16);
    int64_t seq = 0;
    for (const auto& [kind, x, away] :
         {std::tuple(ToolEvent::suture_a, -3.3, a_away_mm), std::tuple(ToolEvent::suture_b, 3.3, b_away_mm)}) {
      ToolEvent e;
      e.seq = seq++, e.tick = 20, e.snapshot = 0, e.kind = kind, e.tool = int32_t(Tool::suture);
      e.chart_x = e.rest_mm[0] = e.seen_mm[0] = x;
      e.seen_mm[2] = away;
      rig.channels->events.push(e);
    }
    rig.solver.step(32);
    EXPECT_EQ(rig.solver.commands() + rig.solver.refused().size(), 1u) << "what is refused is not counted as done";
    return rig.solver.refused().empty() ? std::string() : rig.solver.refused()[0].reason;
  };
  EXPECT_EQ(stitch(0, 0), "");
  EXPECT_EQ(stitch(1.9, 1.9), "");
  for (const bool first : {true, false}) {
    const std::string why = stitch(first ? 3 : 0, first ? 0 : 3);
    EXPECT_NE(why.find("3.0 mm from where it was shown"), std::string::npos) << why;
  }
}

// A device that keeps the real-time thread for too long loses its privilege, and the operator is told.
TEST(RealTime, ASlowTickGivesUpRealTimeAndSaysSo) {
  struct Slow final : Source {
    void poll(int64_t now_ns, SampleSink&) override {
      if (now_ns < 100'000'000 || slept) return;
      slept = true;
      const timespec pause{0, 80'000'000};
      nanosleep(&pause, nullptr);
    }
    bool done() const override { return slept; }
    SourceCounts counts() const override { return {}; }
    bool slept = false;
  };
  Rig rig(std::make_unique<Slow>());
  SessionSettings set = quick();
  set.tail_ticks = 300;
  std::string said;
  set.say = [&](const std::string& line) { said += line + "\n"; };
  const SessionFigures f = run_realtime(rig.lanes(), set, {});
  if (f.scheduling.find("SCHED_FIFO") == std::string::npos) GTEST_SKIP() << "no real-time scheduling here";
  EXPECT_NE(said.find("took more than 50 ms"), std::string::npos) << said;
}

TEST(RealTime, EndsWhenInterrupted) {
  Rig rig(std::make_unique<Endless>());
  SessionSettings set = quick();
  int asked = 0;
  set.interrupted = [&] { return ++asked > 10; };
  EXPECT_TRUE(run_realtime(rig.lanes(), set, {}).interrupted);
}

TEST(RealTime, NoMemoryIsLockedOnceASessionHasEnded) {
  const auto locked_kB = [] {
    std::ifstream in("/proc/self/status");
    for (std::string line; std::getline(in, line);)
      if (line.starts_with("VmLck:")) return std::stol(line.substr(6));
    return -1L;
  };
  Rig rig(std::make_unique<Endless>());
  long during = 0;
  SessionSettings set = quick();
  set.end_tick = 50;
  set.interrupted = [&] { return during = std::max(during, locked_kB()), false; };
  const SessionFigures f = run_realtime(rig.lanes(), set, {});
  EXPECT_EQ(locked_kB(), 0);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer locks no memory";
#endif
  if (f.scheduling.find("memory locked") == std::string::npos) GTEST_SKIP() << "no memory can be locked here";
  EXPECT_GT(during, 1000);
}

}  // namespace test_session
}  // namespace limberg
