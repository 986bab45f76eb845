#pragma once
// A recorded stream handed over as a live session took it: so
// many samples at each tick, whatever their time stamps say.
#include <algorithm>
#include <utility>
#include <vector>

#include "devices/source.h"

namespace limberg {

class TakenSource final : public Source {
 public:
  /// In the order in which they were recorded.
  explicit TakenSource(std::vector<Sample> samples) : samples_(std::move(samples)) {}
  /// At the next poll.
  void allow(int64_t samples) { allowed_ = samples; }
  void poll(int64_t, SampleSink& sink) override {
    for (; allowed_ > 0 && next_ < samples_.size(); --allowed_) sink.on_sample(samples_[next_++]);
    allowed_ = 0;
  }
  bool done() const override { return next_ >= samples_.size(); }
  SourceCounts counts() const override { return {int64_t(next_), 0, 0}; }

 private:
  std::vector<Sample> samples_;
  size_t next_ = 0;
  int64_t allowed_ = 0;
};

}  // namespace limberg
