#pragma once
// A recorded stream as a source: samples read beforehand, handed over when their time has come.
#include <vector>

#include "devices/source.h"

namespace limberg {

class LogSource final : public Source {
 public:
  /// `damaged`: how many events the reader refused, for counts().
  explicit LogSource(std::vector<Sample> samples, int64_t damaged = 0);
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override { return next_ >= samples_.size(); }
  SourceCounts counts() const override { return {int64_t(next_), damaged_, 0}; }
  int64_t last_ns() const { return last_ns_; }  // time of the last sample; 0 when there is none

 private:
  std::vector<Sample> samples_;  // by time; in file order where times are equal
  size_t next_ = 0;
  int64_t damaged_ = 0, last_ns_ = 0;
};

}  // namespace limberg
