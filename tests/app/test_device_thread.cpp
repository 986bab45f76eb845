// What the device thread may not do: take memory, take a lock, write. Every live source, a glove, a stylus with the
// surface cursor and a force device at once, on a thread of 1 kHz, with everything counted that it calls.
#include <gtest/gtest.h>
#include <stdio.h>
#include <time.h>

#include <memory>
#include <mutex>

#include "app/session/clock.h"
#include "app/session/device_lane.h"
#include "app/session/thread.h"
#include "devices/fastrak/port.h"
#include "devices/fastrak/source.h"
#include "devices/force/force_source.h"
#include "devices/lcm_net_source.h"
#include "devices/log_source.h"
#include "tests/app/call_counter.h"
#include "tests/app/malloc_counter.h"
#include "tests/devices/flat_patient.h"

namespace limberg {
namespace test_device_thread {

using namespace test;

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

TEST(DeviceThread, TakesNoMemoryNoLockAndWritesNothing) {
  if (!call_counter::works() || !malloc_counter::works()) GTEST_SKIP() << "a sanitizer has these calls";
  const Snapshot patient = snapshot_of(flat_topology(60, 1));
  fastrak::EmulatedPort glove_port(fastrak::hand_at_work(1));
  Calibration calibration;
  // The hand at work lies 350 mm in front of the transmitter.
  calibration.world_from_tracker_mm = Vec3(-350, 0, 150);
  DeviceFrontEnd front(calibration);
  auto channels = std::make_unique<Channels>();
  const int64_t start = RealClock::monotonic_ns();
  front.add(std::make_unique<fastrak::FastrakSource>(fastrak::parse_source(glove_port.path() + ",fts"), start));
  LcmNetSettings memory;
  memory.url = "memq://";
  front.add(std::make_unique<LcmNetSource>(memory, start));
  SimulatedHand hand;
  hand.target = [](double t) { return Vec3(10 * std::sin(t), 0, 5 - 8 * std::min(1.0, t)); };
  channels->press = std::make_shared<PressLine>();
  front.add(std::make_unique<ForceSource>(std::make_unique<SimulatedForceDevice>(hand), ForceSourceSettings{},
                                          channels->press));
  ControlSample cursor;
  cursor.device_id = 901;
  cursor.kind = ControlSample::cursor;
  cursor.value[0] = 0.5;
  front.add(std::make_unique<LogSource>(std::vector<Sample>{cursor}));
  channels->patient_to_device.for_each_slot([&](PatientState& p) { p.snapshot = patient; });
  DeviceLane lane(front, *channels, true);
  uint64_t memory_taken = 0, locks = 0, writes = 0, counted = 0, snapshots = 0, answered = 0;
  {
    const Thread device([&] {
      const RealClock clock(start);
      constexpr int64_t kWarm = 200, kTicks = 3500;
      for (int64_t tick = 1; tick < kTicks; ++tick) {
        clock.sleep_until_ns(tick * kDeviceTickNs);
        tick = std::max(tick, clock.now_ns() / kDeviceTickNs);
        const uint64_t m = malloc_counter::count(), l = call_counter::locks(), w = call_counter::writes();
        lane.tick(tick);
        if (tick > kWarm)
          memory_taken += malloc_counter::count() - m, locks += call_counter::locks() - l,
              writes += call_counter::writes() - w, ++counted;
      }
    });
    // Meanwhile the solver's side publishes, and the recorder's side empties its ring.
    for (uint64_t step = 1; RealClock::monotonic_ns() - start < 3'600'000'000; ++step) {
      Snapshot& s = channels->patient_to_device.writing().snapshot;
      s.step = step;
      channels->patient_to_device.publish();
      ++snapshots;
      for (Sample x; channels->samples.pop(x);) {
      }
      for (ToolEvent e; channels->events.pop(e);) {
      }
      if (const PressQuestion* q = channels->press->asked())
        channels->press->answer({q->topology_version, q->triangle, 0.2, q->depth_mm, 0, 1}), ++answered;
      const timespec pause{0, 16'000'000};
      nanosleep(&pause, nullptr);
    }
  }
  const FrontEndCounts c = front.counts();
  EXPECT_GT(counted, 100u);
  EXPECT_GT(snapshots, 20u);
  EXPECT_GT(answered, 10u) << "the force device asked";
  EXPECT_GT(c.glove.forefinger.used, 10) << "the glove was followed";
  EXPECT_EQ(memory_taken, 0u);
  EXPECT_EQ(locks, 0u);
  EXPECT_EQ(writes, 0u);
}

}  // namespace test_device_thread
}  // namespace limberg
