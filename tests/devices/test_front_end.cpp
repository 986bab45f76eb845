// The front end as the device thread drives it: nothing is allocated between changes of topology, and it is quick.
#include <gtest/gtest.h>
#include <time.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "devices/emulator.h"
#include "devices/front_end.h"
#include "devices/log_source.h"
#include "tests/devices/flat_patient.h"

namespace test_front_end {
std::atomic<int64_t> allocations = 0;
}  // namespace test_front_end

// Every allocation of this program is counted.
__attribute__((noinline)) void* operator new(size_t n) {
  ++test_front_end::allocations;
  if (void* p = std::malloc(n ? n : 1)) return p;
  throw std::bad_alloc();
}
__attribute__((noinline)) void* operator new(size_t n, const std::nothrow_t&) noexcept {
  ++test_front_end::allocations;
  return std::malloc(n ? n : 1);
}
__attribute__((noinline)) void operator delete(void* p) noexcept { std::free(p); }
__attribute__((noinline)) void operator delete(void* p, size_t) noexcept { std::free(p); }
__attribute__((noinline)) void operator delete(void* p, const std::nothrow_t&) noexcept { std::free(p); }

namespace limberg {
namespace test_front_end {

using namespace test;

struct CountEvents final : EventSink {
  bool push(const ToolEvent&) override { return ++n, true; }
  int n = 0;
};
struct CountSamples final : SampleSink {
  void on_sample(const Sample&) override { ++n; }
  int n = 0;
};

std::vector<Sample> strokes(const Snapshot& s) {
  std::vector<Command> script;
  for (int i = 0; i < 6; ++i) script.push_back(Incise{{{-40, 5.0 * i}, {40, 5.0 * i}, {40, 5.0 * i + 3}}, 4, 90});
  script.push_back(SetHook{1, {0, 0}});
  script.push_back(Suture{{0, 0}, {3, 3}});
  EmulatedSurgeon surgeon(script);
  Samples samples;
  for (int64_t t = 0; !surgeon.done() && t < 100'000; ++t) {
    surgeon.look(s);
    surgeon.poll(t * 1'000'000, samples);
  }
  return samples.all;
}

TEST(FrontEnd, ATickAllocatesNothingAndIsCheap) {
  // 57,800 triangles of skin, as a shipped scene has.
  const Snapshot s = snapshot_of(flat_topology(170, 1));
  auto source = std::make_unique<LogSource>(strokes(s));
  DeviceFrontEnd front{Calibration{}};
  front.add(std::move(source));
  CountEvents events;
  CountSamples samples;
  ToolState hand;
  int64_t tick = 0;
  while (tick < 50) front.tick(tick++, s, events, samples, hand);  // builds the index
  const int64_t before = ::test_front_end::allocations;
  timespec a, b;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &a);
  const int64_t first = tick;
  while (!front.done()) front.tick(tick++, s, events, samples, hand);
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &b);
  EXPECT_EQ(::test_front_end::allocations, before);
  EXPECT_GT(events.n, 500);
  const double us = (double(b.tv_sec - a.tv_sec) * 1e9 + double(b.tv_nsec - a.tv_nsec)) / double(tick - first) * 1e-3;
  std::printf("  %.1f us of processor time a tick over %lld ticks\n", us, static_cast<long long>(tick - first));
  EXPECT_EQ(front.counts().missed_presses, 0);
}

TEST(FrontEnd, EverySampleIsRecordedAsReceived) {
  const Snapshot s = snapshot_of(flat_topology(40, 1));
  const std::vector<Sample> sent = strokes(s);
  DeviceFrontEnd front{Calibration{}};
  front.add(std::make_unique<LogSource>(sent));
  Samples recorded;
  Events events;
  ToolState hand;
  for (int64_t tick = 0; !front.done(); ++tick) front.tick(tick, s, events, recorded, hand);
  EXPECT_EQ(recorded.all.size(), sent.size());
  EXPECT_EQ(front.counts().sources.samples, int64_t(sent.size()));
}

TEST(FrontEnd, TwoSourcesAndASecondStylus) {
  const Snapshot s = snapshot_of(flat_topology(40, 1));
  std::vector<Sample> other;
  for (int i = 0; i < 100; ++i) {
    StylusSample p;
    p.device_id = 55;
    p.seq = i;
    p.t_ns = 1'000'000'000 + int64_t(i) * 8'000'000;
    other.push_back(p);
  }
  DeviceFrontEnd front{Calibration{}};
  EXPECT_FALSE(front.done());
  front.add(std::make_unique<LogSource>(strokes(s)));
  front.add(std::make_unique<LogSource>(other, 2));
  Samples recorded;
  Events events;
  ToolState hand;
  for (int64_t tick = 0; !front.done(); ++tick) front.tick(tick, s, events, recorded, hand);
  EXPECT_EQ(front.counts().other_devices, 100);
  EXPECT_EQ(front.counts().sources.malformed, 2);
  EXPECT_EQ(front.counts().tracking.jumps, 0);
  EXPECT_EQ(events.count(ToolEvent::stroke_end), 6);
}

// A headset is put on and taken off again: its stylus is followed meanwhile, from its own first number.
TEST(FrontEnd, WhoseStylusIsFollowedIsSaid) {
  std::vector<Sample> all;
  const auto put = [&](int32_t device, int64_t seq, int64_t ms, double x) {
    StylusSample s;
    s.device_id = device, s.seq = seq, s.t_ns = ms * 1'000'000, s.tip_mm = {x, 0, 40};
    all.emplace_back(s);
  };
  const auto follow = [&](int64_t ms, int32_t device) {
    ControlSample c;
    c.kind = ControlSample::stylus, c.t_ns = ms * 1'000'000, c.value[0] = device, c.seq = ms;
    all.emplace_back(c);
  };
  for (int64_t ms = 1; ms < 600; ms += 4) {
    if (ms == 201) follow(ms - 1, 600);
    if (ms == 401) follow(ms - 1, 0);
    put(50, 1000 + ms, ms, -20);
    put(600, ms, ms + 1, 20);
  }
  DeviceFrontEnd front{Calibration{}};
  front.add(std::make_unique<LogSource>(all));
  CountEvents events;
  CountSamples samples;
  ToolState state;
  const Snapshot s = snapshot_of(flat_topology(10, 1));
  for (int64_t tick = 0; tick < 600; ++tick) {
    front.tick(tick, s, events, samples, state);
    const double wanted = tick < 199 ? -20 : tick < 399 ? 20 : -20;
    if (tick % 200 < 20 || tick % 200 > 190) continue;
    EXPECT_NEAR(state.tip_mm[0], wanted, 1e-6) << tick;
  }
  EXPECT_EQ(samples.n, int(all.size()));
}

TEST(FrontEnd, SilenceIsToldToTheSolver) {
  const Snapshot s = snapshot_of(flat_topology(40, 1));
  std::vector<Sample> few;
  for (int i = 0; i < 10; ++i) {
    StylusSample p;
    p.seq = i;
    p.t_ns = int64_t(i) * 8'000'000;
    few.push_back(p);
  }
  DeviceFrontEnd front{Calibration{}};
  front.add(std::make_unique<LogSource>(few));
  Samples recorded;
  Events events;
  ToolState hand;
  EXPECT_EQ(hand.valid, 0);
  for (int64_t tick = 0; tick <= 170; ++tick) front.tick(tick, s, events, recorded, hand);
  EXPECT_EQ(hand.valid, 1);
  for (int64_t tick = 171; tick < 200; ++tick) front.tick(tick, s, events, recorded, hand);
  EXPECT_EQ(hand.valid, 0);
  EXPECT_EQ(front.last_sample_ns(), 72'000'000);
}

}  // namespace test_front_end
}  // namespace limberg
