#pragma once
// From the thread that receives to the thread that polls: samples in order, neither side ever waiting.
//
// A sample is stamped within the tick that consumes it, so that a replay by time stamps consumes it in the same tick.
// When a reading was true is another matter, and another field (TrackerSample::true_ns).
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <variant>
#include <vector>

#include "devices/source.h"

namespace limberg {

class SampleQueue {
 public:
  /// Holds at least `capacity` samples.
  explicit SampleQueue(size_t capacity) {
    size_t size = 2;
    while (size < capacity) size *= 2;
    slot_.resize(size);
  }

  /// Receiver only. False: full.
  bool push(const Sample& s) {
    const size_t at = head_.load(std::memory_order_relaxed);
    if (at - tail_.load(std::memory_order_acquire) >= slot_.size()) return false;
    slot_[at & (slot_.size() - 1)] = s;
    head_.store(at + 1, std::memory_order_release);
    return true;
  }

  /// Poller only: everything whose time has come.
  void poll(int64_t now_ns, SampleSink& sink) {
    const size_t head = head_.load(std::memory_order_acquire);
    for (size_t at = tail_.load(std::memory_order_relaxed); at != head; ++at) {
      Sample& s = slot_[at & (slot_.size() - 1)];
      int64_t& t_ns = *std::visit([](auto& v) { return &v.t_ns; }, s);
      if (t_ns > now_ns) break;
      t_ns = std::max({t_ns, last_now_ns_ + 1, last_t_ns_ + 1});
      last_t_ns_ = t_ns;
      ++handed_;
      sink.on_sample(s);
      tail_.store(at + 1, std::memory_order_release);
    }
    last_now_ns_ = now_ns;
  }
  int64_t handed_over() const { return handed_; }  // poller only

 private:
  std::vector<Sample> slot_;
  alignas(64) std::atomic<size_t> head_{0};
  alignas(64) std::atomic<size_t> tail_{0};
  int64_t handed_ = 0, last_t_ns_ = -1, last_now_ns_ = -1;
};

}  // namespace limberg
