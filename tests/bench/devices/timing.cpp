#include "tests/bench/devices/timing.h"

#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <memory>
#include <mutex>

#include "app/operating_point/cpu_clock.h"
#include "app/session/clock.h"
#include "app/session/thread.h"
#include "app/session/triple_buffer.h"
#include "devices/spsc_ring.h"
#include "tests/bench/devices/hogs.h"

namespace limberg::bench {

namespace {

bool be_fifo(int priority) {
  sched_param p{};
  p.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &p) == 0;
}

constexpr size_t kWords = 32;  // 256 bytes
struct Value {
  std::array<uint64_t, kWords> word{};
  void set(uint64_t v) { word.fill(v); }
  bool torn() const {
    for (const uint64_t w : word)
      if (w != word[0]) return true;
    return false;
  }
};

struct Triple {
  static constexpr const char* name = "triple buffer, 256 bytes";
  TripleBuffer<Value> b;
  void write(uint64_t v) { b.writing().set(v), b.publish(); }
  bool read(uint64_t hold_ns) {
    b.update();
    const bool torn = b.reading().torn();
    spend(hold_ns);
    return torn;
  }
  static void spend(uint64_t ns) {
    for (const int64_t end = RealClock::monotonic_ns() + int64_t(ns); ns > 0 && RealClock::monotonic_ns() < end;) {
    }
  }
};
struct Mutex {
  static constexpr const char* name = "std::mutex, 256 bytes";
  std::mutex m;
  Value v;
  void write(uint64_t x) {
    const std::lock_guard lock(m);
    v.set(x);
  }
  bool read(uint64_t hold_ns) {
    const std::lock_guard lock(m);
    const bool torn = v.torn();
    Triple::spend(hold_ns);
    return torn;
  }
};

template <class B>
BufferFigures buffer_trial(int64_t writes) {
  auto b = std::make_unique<B>();
  BufferFigures f;
  f.name = B::name;
  constexpr int kAlone = 200'000;
  double before = cpu_ms();
  for (int i = 0; i < kAlone; ++i) b->write(uint64_t(i));
  f.ns_write = (cpu_ms() - before) * 1e6 / kAlone;
  before = cpu_ms();
  for (int i = 0; i < kAlone; ++i) f.torn += b->read(0);
  f.ns_read = (cpu_ms() - before) * 1e6 / kAlone;
  std::atomic<bool> stop{false};
  std::atomic<uint64_t> torn{0};
  {
    const ScheduledThread reader([&] {
      while (!stop.load(std::memory_order_relaxed)) torn.fetch_add(b->read(0), std::memory_order_relaxed);
    });
    for (int64_t i = 0; i < writes; ++i) {
      const int64_t t0 = RealClock::monotonic_ns();
      b->write(uint64_t(i));
      f.writer.add(RealClock::monotonic_ns() - t0);
    }
    stop = true;
  }
  f.torn += torn.load();
  return f;
}

template <class B>
InversionFigures inversion_trial(double seconds) {
  InversionFigures f;
  f.name = B::name;
  auto b = std::make_unique<B>();
  const Hogs hogs(2);
  std::atomic<bool> stop{false};
  const ScheduledThread reader([&] {
    constexpr uint64_t kHoldNs = 20'000;
    while (!stop.load(std::memory_order_relaxed)) b->read(kHoldNs);
  });
  {
    const ScheduledThread writer([&] {
      be_fifo(60);
      const RealClock clock(RealClock::monotonic_ns());
      for (int64_t tick = 1; double(tick) * 1e-3 < seconds; ++tick) {
        clock.sleep_until_ns(tick * kDeviceTickNs);
        const int64_t t0 = clock.now_ns();
        b->write(uint64_t(tick));
        f.writer.add(clock.now_ns() - t0);
        tick = std::max(tick, clock.now_ns() / kDeviceTickNs);
      }
    });
  }
  stop = true;
  return f;
}

}  // namespace

WakeFigures wake_trial(double seconds, bool fifo, int hog_count) {
  WakeFigures f;
  const Hogs hogs(hog_count);
  {
    const ScheduledThread loop([&] {
      request_exact_timers();
      const bool got = fifo && be_fifo(80);
      f.settings = std::string(got    ? "SCHED_FIFO 80"
                               : fifo ? "SCHED_FIFO refused"
                                      : "SCHED_OTHER") +
                   (hog_count ? ", " + std::to_string(hog_count) + " hogs" : ", no hogs of ours");
      const RealClock clock(RealClock::monotonic_ns());
      for (int64_t tick = 1; double(tick) * 1e-3 < seconds; ++tick) {
        clock.sleep_until_ns(tick * kDeviceTickNs);
        const int64_t late = clock.now_ns() - tick * kDeviceTickNs;
        f.wake.add(late);
        ++f.ticks;
        if (late >= kDeviceTickNs) ++f.late, tick += late / kDeviceTickNs;
      }
    });
  }
  return f;
}

std::vector<BufferFigures> buffer_trials(int64_t writes) {
  return {buffer_trial<Triple>(writes), buffer_trial<Mutex>(writes)};
}

std::vector<InversionFigures> inversion_trials(double seconds) {
  bool allowed = false;
  {
    const ScheduledThread t([&] { allowed = be_fifo(60); });
  }
  if (!allowed) return {};
  return {inversion_trial<Triple>(seconds), inversion_trial<Mutex>(seconds)};
}

}  // namespace limberg::bench
