#pragma once
// What each of the three threads says about its own timing, cheaply enough to be said on every tick.
//
// Histogram: counts in buckets that grow by 1/32 of an octave (relative error of a percentile <= 3.2 %), from 1 ns to
// 2^40 ns (18 min), in a fixed block of memory. One thread adds; others read after that thread has ended.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace limberg {

class Histogram {
 public:
  void add(int64_t ns) noexcept {
    const uint64_t v = ns < 0 ? 0 : uint64_t(ns);
    ++count_[bucket(v)];
    ++total_;
    if (v > max_) max_ = v;
  }
  uint64_t total() const { return total_; }
  int64_t max_ns() const { return int64_t(max_); }
  /// The smallest time that at least the fraction p of all values does not exceed; 0 when there are none.
  int64_t percentile_ns(double p) const {
    const auto want = uint64_t(p * double(total_));
    uint64_t seen = 0;
    for (size_t b = 0; b < count_.size(); ++b)
      if ((seen += count_[b]) > want || (seen == total_ && seen > 0)) return int64_t(std::min(upper(b), max_));
    return 0;
  }

 private:
  static constexpr int kSub = 5, kOctaves = 40;  // 32 buckets an octave
  static size_t bucket(uint64_t v) {
    if (v < (1u << kSub)) return size_t(v);
    const int e = std::bit_width(v) - 1 - kSub;  // v >> e lies in [32, 64)
    const size_t b = (size_t(e + 1) << kSub) + size_t((v >> e) - (1u << kSub));
    return b < kBuckets ? b : kBuckets - 1;
  }
  static uint64_t upper(size_t b) {  // the largest value that falls into bucket b
    if (b < (1u << kSub)) return b;
    const auto e = int(b >> kSub) - 1;
    const uint64_t lead = (1u << kSub) + (b & ((1u << kSub) - 1));
    return ((lead + 1) << e) - 1;
  }
  static constexpr size_t kBuckets = size_t(kOctaves - kSub + 1) << kSub;
  std::array<uint32_t, kBuckets> count_{};
  uint64_t total_ = 0, max_ = 0;
};

/// The watchdog figures of one thread.
struct LaneTimes {
  Histogram wake;  // how late the tick began
  Histogram work;  // how long it took
  Histogram age;   // age of the newest thing it read, at the end of its work
  uint64_t ticks = 0;
  uint64_t late = 0;     // ticks that began more than 1 ms (device) or one period (others) late
  uint64_t skipped = 0;  // whole periods given up, never made up for
};

}  // namespace limberg
