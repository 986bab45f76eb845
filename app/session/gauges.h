#pragma once
// How the three lanes are doing, for a screen to show while
// they run: each figure has one writer, any thread may read
// it. Relaxed: figures for the eye, not for decisions.
#include <atomic>
#include <cstdint>

namespace limberg {

struct LaneGauges {
  std::atomic<int64_t> tick{0};              // device tick: ms since the start
  std::atomic<int64_t> behind_ms{0};         // how old what the hand has of the patient is
  std::atomic<int64_t> pace_permille{1000};  // of the session's clock, over a second, against the wall's
  std::atomic<int64_t> device_late{0};       // ticks that began more than 1 ms late
  std::atomic<int64_t> sample_ns{-1};        // time stamp of the newest sample
  std::atomic<int64_t> samples{0};
  std::atomic<int64_t> device_ns{0}, solver_ns{0}, frame_ns{0};  // how long the last tick, step and frame took
  std::atomic<int64_t> frames{0};                                // drawn so far
  std::atomic<int64_t> loss_permille{
      -1};  // of the solver's speed by the pictures, taken over all the time; -1: not known

  static void set(std::atomic<int64_t>& g, int64_t v) { g.store(v, std::memory_order_relaxed); }
  static int64_t get(const std::atomic<int64_t>& g) { return g.load(std::memory_order_relaxed); }
};

}  // namespace limberg
