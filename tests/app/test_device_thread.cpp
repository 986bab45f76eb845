// What the device thread may not do: take memory, take a lock, write. Every live source, a glove, a stylus with the
// surface cursor and a force device at once, on a thread of 1 kHz, with everything counted that it calls, while the
// patient is cut.
#include <gtest/gtest.h>
#include <stdio.h>
#include <time.h>

#include <algorithm>
#include <memory>
#include <mutex>

#include "app/session/clock.h"
#include "app/session/device_lane.h"
#include "app/session/solver_lane.h"
#include "app/session/thread.h"
#include "devices/fastrak/port.h"
#include "devices/fastrak/source.h"
#include "devices/force/force_source.h"
#include "devices/lcm_net_source.h"
#include "devices/log_source.h"
#include "tests/app/call_counter.h"
#include "tests/app/fake_patient.h"
#include "tests/app/malloc_counter.h"

namespace limberg {
namespace test_device_thread {

TEST(CallCounter, SeesALockAndALine) {
  if (!call_counter::works()) GTEST_SKIP() << "a sanitizer has these calls";
  const uint64_t locks = call_counter::locks(), writes = call_counter::writes();
  std::mutex m;
  { const std::lock_guard lock(m); }
  EXPECT_EQ(call_counter::locks(), locks + 1);
  std::fputs("", stdout);
  std::printf("%d ", 3);
  EXPECT_GT(call_counter::writes(), writes);
}

/// What a person and a panel say meanwhile: every tool, and controls that carry numbers and names as text.
std::vector<Sample> controls() {
  std::vector<Sample> all;
  const auto say = [&](int64_t t_ms, int32_t kind, Tool tool = Tool::none, std::array<double, 4> value = {},
                       const char* text = "") {
    ControlSample c;
    c.device_id = 901, c.seq = int64_t(all.size()), c.t_ns = t_ms * 1'000'000;
    c.kind = kind, c.tool = tool, c.value = value, c.text = ShortText(text);
    all.push_back(c);
  };
  say(0, ControlSample::cursor, Tool::none, {0.5});
  int64_t t_ms = 300;
  for (const Tool tool :
       {Tool::scalpel, Tool::suture_row, Tool::suture, Tool::hook, Tool::saw, Tool::scissors, Tool::excise})
    say(t_ms, ControlSample::select_tool, tool), t_ms += 400;
  say(350, ControlSample::undo), say(360, ControlSample::redo);
  const auto tell = [&](int64_t t, const Command& command) {
    CommandSample c = command_sample(command);
    c.device_id = 901, c.t_ns = t * 1'000'000;
    all.push_back(c);
  };
  ConnectTissue tissue;
  tissue.name = "a long name of a place and of another";
  tell(1000, HeadCommand(tissue));
  tell(1100, HeadCommand(MoveFragment{{-1, {1, 2, 3}}, {{1.25, -3.5, 0}, {12.345, -6.789, 1e-3}, {}}, 0}));
  for (int i = 0; i < 80; ++i) tell(320 + 30 * i, Undermine{{{0, 0}, {double(i), 5}, {9, 9}}, 4});
  say(1200, ControlSample::cursor, Tool::none, {0.5, 1});
  say(1300, ControlSample::cursor);
  std::stable_sort(all.begin(), all.end(), [](const Sample& a, const Sample& b) { return time_of(a) < time_of(b); });
  for (size_t i = 0; i < all.size(); ++i) std::visit([&](auto& sample) { sample.seq = int64_t(i); }, all[i]);
  return all;
}

TEST(DeviceThread, TakesNoMemoryNoLockAndWritesNothingWhileThePatientIsCut) {
  if (!call_counter::works() || !malloc_counter::works()) GTEST_SKIP() << "a sanitizer has these calls";
  FakePatient patient(nullptr, 60, 2);
  fastrak::EmulatedPort glove_port(fastrak::hand_at_work(1));
  Calibration calibration;
  // The hand at work lies 350 mm in front of the transmitter.
  calibration.world_from_tracker_mm = Vec3(-350, 0, 150);
  DeviceFrontEnd front(calibration);
  auto channels = std::make_unique<Channels>();
  SolverLane solver(patient, *channels, {});
  const int64_t start = RealClock::monotonic_ns();
  SimulatedHand hand;
  hand.target = [](double t) { return Vec3(10 * std::sin(t), 0, 5 - 8 * std::min(1.0, t)); };
  hand.pressed = [](double t) { return std::fmod(t, 0.2) > 0.1; };
  channels->press = std::make_shared<PressLine>();
  front.add(std::make_unique<ForceSource>(std::make_unique<SimulatedForceDevice>(hand), ForceSourceSettings{},
                                          channels->press));
  front.add(std::make_unique<fastrak::FastrakSource>(fastrak::parse_source(glove_port.path() + ",fts"), start));
  LcmNetSettings memory;
  memory.url = "memq://";
  front.add(std::make_unique<LcmNetSource>(memory, start));
  front.add(std::make_unique<LogSource>(controls()));
  solver.start();
  DeviceLane lane(front, *channels, true);
  uint64_t memory_taken = 0, memory_freed = 0, locks = 0, writes = 0, counted = 0, topologies = 0, seen = 0;
  {
    const ScheduledThread device([&] {
      const RealClock clock(start);
      constexpr int64_t kWarm = 200, kTicks = 3500;
      for (int64_t tick = 1; tick < kTicks; ++tick) {
        clock.sleep_until_ns(tick * kDeviceTickNs);
        tick = std::max(tick, clock.now_ns() / kDeviceTickNs);
        const uint64_t m = malloc_counter::count(), f = malloc_counter::frees(), l = call_counter::locks(),
                       w = call_counter::writes();
        lane.tick(tick);
        if (tick > kWarm) {
          memory_taken += malloc_counter::count() - m, memory_freed += malloc_counter::frees() - f;
          locks += call_counter::locks() - l, writes += call_counter::writes() - w, ++counted;
        }
        const uint64_t version = channels->patient_to_device.reading().snapshot.topology_version;
        topologies += version != seen, seen = version;
      }
    });
    // Meanwhile the solver cuts at every eighth step and publishes, and the recorder's side empties its ring.
    for (int64_t tick = 16; RealClock::monotonic_ns() - start < 3'600'000'000; tick += 16) {
      if (tick % 128 == 0) patient.apply(Incise{{{-4, -5}, {0, -5}}, 4, 90});
      solver.step(tick);
      for (Sample x; channels->samples.pop(x);) {
      }
      const timespec pause{0, 16'000'000};
      nanosleep(&pause, nullptr);
    }
  }
  const FrontEndCounts c = front.counts();
  EXPECT_GT(counted, 100u);
  EXPECT_GT(topologies, 10u) << "the device thread has seen cuts";
  EXPECT_GT(c.events, 10) << "tools were used";
  EXPECT_GT(c.glove.forefinger.used, 10) << "the glove was followed";
  EXPECT_EQ(memory_taken, 0u);
  EXPECT_EQ(memory_freed, 0u);
  EXPECT_EQ(locks, 0u);
  EXPECT_EQ(writes, 0u);
}

}  // namespace test_device_thread
}  // namespace limberg
