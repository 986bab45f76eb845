#pragma once
// From the thread that receives to the thread that polls: samples in order, neither side ever waiting.
//
// A sample is stamped within the tick that consumes it, so that a replay by time stamps consumes it in the same tick.
// When a reading was true is another matter, and another field (TrackerSample::true_ns), which stays within what a
// recording takes of the stamp: a clock that stood still and leapt lies between the two.
#include <algorithm>
#include <cstdint>
#include <variant>

#include "devices/source.h"
#include "devices/spsc_ring.h"

namespace limberg {

class SampleQueue {
 public:
  /// Holds at least `capacity` samples.
  explicit SampleQueue(size_t capacity) : ring_(capacity) {}

  /// Receiver only. False: full.
  bool push(const Sample& s) { return ring_.push(s); }

  /// Poller only: everything whose time has come.
  void poll(int64_t now_ns, SampleSink& sink) {
    while (Sample* s = ring_.front()) {
      int64_t& t_ns = *std::visit([](auto& v) { return &v.t_ns; }, *s);
      if (t_ns > now_ns) break;
      t_ns = std::max({t_ns, last_now_ns_ + 1, last_t_ns_ + 1});
      last_t_ns_ = t_ns;
      if (auto* t = std::get_if<TrackerSample>(s)) t->true_ns = std::clamp(t->true_ns, t_ns - kOldestReadingNs, t_ns);
      ++handed_;
      sink.on_sample(*s);
      ring_.drop();
    }
    last_now_ns_ = now_ns;
  }
  int64_t handed_over() const { return handed_; }  // poller only

 private:
  SpscRing<Sample> ring_;
  int64_t handed_ = 0, last_t_ns_ = -1, last_now_ns_ = -1;
};

}  // namespace limberg
