#include "devices/continued_source.h"

#include <algorithm>
#include <map>

#include "devices/message_codec.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

bool of_stylus(const Sample& s) {
  const auto* tracker = std::get_if<TrackerSample>(&s);
  return std::holds_alternative<StylusSample>(s) || (tracker && tracker->role == StationRole::stylus);
}

}  // namespace

EarlierPart::EarlierPart(const std::vector<Sample>& samples, int64_t from_ns) : from_ns_(from_ns) {
  const Sample* last_of_stylus = nullptr;
  for (const Sample& sample : samples)
    std::visit(
        [&](const auto& s) {
          Stream* const at = stream(stream_of(s), s.device_id);
          if (!at) throw InputError("", 0, "too many devices in a recording that is to go on; expected at most 512");
          at->last = std::max(at->last, s.seq);
          if (!of_stylus(sample)) return;
          if (!stylus_) stylus_ = s.device_id;
          if (s.device_id == *stylus_) last_of_stylus = &sample;
        },
        sample);
  if (!last_of_stylus) return;
  const auto let_go = [&](auto s) {
    if (s.buttons == 0) return;
    s.buttons = 0, s.t_ns = from_ns;
    s.seq = ++stream(stream_of(s), s.device_id)->last;
    let_go_.push_back(s);
  };
  if (const auto* s = std::get_if<StylusSample>(last_of_stylus)) let_go(*s);
  if (const auto* s = std::get_if<TrackerSample>(last_of_stylus)) let_go(*s);
}

EarlierPart::Stream* EarlierPart::stream(int number, int32_t device) {
  for (size_t i = 0; i < n_; ++i)
    if (streams_[i].number == number && streams_[i].device == device) return &streams_[i];
  if (n_ == kMost) return nullptr;
  streams_[n_] = {number, device};
  return &streams_[n_++];
}

void EarlierPart::put_after(Sample& sample) {
  const bool moves = of_stylus(sample);
  std::visit(
      [&](auto& s) {
        if (moves && stylus_ && !taker_) taker_ = s.device_id;
        if (taker_ && s.device_id == *taker_ &&
            (std::is_same_v<decltype(s), StylusSample&> || std::is_same_v<decltype(s), TrackerSample&>))
          s.device_id = *stylus_;
        s.t_ns += from_ns_;
        if (Stream* const at = stream(stream_of(s), s.device_id)) {
          if (!at->goes_on) at->goes_on = true, at->shift = at->last < 0 ? 0 : at->last + 1 - s.seq;
          s.seq += at->shift;
        }
      },
      sample);
  if (auto* t = std::get_if<TrackerSample>(&sample)) t->true_ns += from_ns_;
}

ContinuedSource::ContinuedSource(std::unique_ptr<Source> source, std::shared_ptr<EarlierPart> earlier)
    : source_(std::move(source)), earlier_(std::move(earlier)), follower_(dynamic_cast<ToolFollower*>(source_.get())) {}

void ContinuedSource::poll(int64_t now_ns, SampleSink& sink) {
  sink_ = &sink;
  source_->poll(now_ns - earlier_->from_ns(), *this);
  sink_ = nullptr;
}

void ContinuedSource::hold(const ToolState& state) {
  if (follower_) follower_->hold(state);
}

void ContinuedSource::on_sample(const Sample& sample) {
  Sample moved = sample;
  earlier_->put_after(moved);
  sink_->on_sample(moved);
}

}  // namespace limberg
