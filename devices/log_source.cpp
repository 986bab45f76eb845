#include "devices/log_source.h"

#include <algorithm>

namespace limberg {

namespace {}  // namespace

LogSource::LogSource(std::vector<Sample> samples, int64_t damaged) : samples_(std::move(samples)), damaged_(damaged) {
  std::stable_sort(samples_.begin(), samples_.end(),
                   [](const Sample& a, const Sample& b) { return time_of(a) < time_of(b); });
  if (!samples_.empty()) last_ns_ = time_of(samples_.back());
}

void LogSource::poll(int64_t now_ns, SampleSink& sink) {
  while (next_ < samples_.size() && time_of(samples_[next_]) <= now_ns) sink.on_sample(samples_[next_++]);
}

}  // namespace limberg
