#pragma once
// Time as the lanes are given it: nanoseconds since the session's start.
#include <time.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "devices/monotonic.h"
#include "devices/session_time.h"

namespace limberg {

constexpr int64_t kNsPerMs = 1'000'000;
constexpr int64_t kDeviceTickNs = kNsPerMs;  // 1 kHz

/// Processor time of the calling thread.
inline int64_t thread_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

/// CLOCK_MONOTONIC since a given moment of it.
class RealClock {
 public:
  explicit RealClock(int64_t start_ns) : start_(start_ns) {}
  int64_t now_ns() const { return monotonic_ns() - start_; }
  /// Sleeps until the given time; returns at once when it has passed.
  void sleep_until_ns(int64_t t_ns) const {
    const int64_t at = start_ + t_ns;
    const timespec ts{at / 1'000'000'000, at % 1'000'000'000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &ts, nullptr) != 0) {  // only a signal ends it early
    }
  }
  static int64_t monotonic_ns() { return limberg::monotonic_ns(); }

 private:
  int64_t start_ = 0;
};

/// Session time that may be held: what has passed since the start, less what it was held for so far. With `slowed` it
/// passes as that says, and is not held.
class PacedClock {
 public:
  PacedClock(int64_t start_ns, const std::atomic<int64_t>& held_ns, const SlowedTime* slowed = nullptr)
      : real_(start_ns), held_(held_ns), slowed_(slowed) {}
  int64_t now_ns() const { return slowed_ ? slowed_->at(wall_ns()) : wall_ns() - held_.load(); }
  /// Since the start, whatever the session's time does.
  int64_t wall_ns() const { return real_.now_ns(); }
  void sleep_until_ns(int64_t t_ns) const {
    if (slowed_) return sleep_slowed(t_ns);
    for (int64_t held = held_.load();;) {
      real_.sleep_until_ns(t_ns + held);
      const int64_t now = held_.load();
      if (now == held) return;
      held = now;
    }
  }

 private:
  // A pace may rise while somebody sleeps: while it is low, nobody sleeps for long.
  void sleep_slowed(int64_t t_ns) const {
    for (int64_t now = now_ns(); now < t_ns; now = now_ns()) {
      const int64_t wall = wall_ns(), until = slowed_->wall_at(t_ns);
      real_.sleep_until_ns(until - wall > t_ns - now + kNsPerMs / 100 ? std::min(until, wall + kNsPerMs) : until);
    }
  }

  RealClock real_;
  const std::atomic<int64_t>& held_;
  const SlowedTime* slowed_;
};

/// Time that passes only when it is told to.
class VirtualClock {
 public:
  int64_t now_ns() const { return now_; }
  void advance_ns(int64_t d) { now_ += d; }

 private:
  int64_t now_ = 0;
};

}  // namespace limberg
