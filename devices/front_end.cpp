#include "devices/front_end.h"

#include <algorithm>

namespace limberg {

DeviceFrontEnd::DeviceFrontEnd(const Calibration& calibration, const GestureSettings& gestures)
    : tracker_(calibration), gestures_(gestures) {}

void DeviceFrontEnd::add(std::unique_ptr<Source> source) { sources_.push_back(std::move(source)); }

void DeviceFrontEnd::tick(int64_t tick, const Snapshot& snapshot, EventSink& events, SampleSink& recorder, ToolState& state) {
  tick_ = tick;
  snapshot_ = &snapshot;
  events_ = &events;
  recorder_ = &recorder;
  edges_ = 0;
  const int64_t now_ns = tick * kTickNs;
  for (const auto& source : sources_) {
    source->look(snapshot);
    source->poll(now_ns, *this);
  }
  gestures_.tick(tick, tracker_.at(now_ns), pressed_, edges_, snapshot, events);
  state = gestures_.state();
  snapshot_ = nullptr;
  events_ = nullptr;
  recorder_ = nullptr;
}

void DeviceFrontEnd::on_sample(const Sample& sample) {
  recorder_->on_sample(sample);
  if (const auto* c = std::get_if<ControlSample>(&sample)) {
    last_sample_ns_ = std::max(last_sample_ns_, c->t_ns);
    gestures_.control(*c, tick_, *snapshot_, *events_);
    return;
  }
  if (!std::holds_alternative<StylusSample>(sample)) return;
  const auto& s = std::get<StylusSample>(sample);
  last_sample_ns_ = std::max(last_sample_ns_, s.t_ns);
  if (!have_stylus_) {
    have_stylus_ = true;
    stylus_ = s.device_id;
  }
  if (s.device_id != stylus_) {
    ++other_devices_;
    return;
  }
  tracker_.add(s);
  const bool pressed = s.buttons & 1;
  if (pressed != pressed_) ++edges_;
  pressed_ = pressed;
}

bool DeviceFrontEnd::done() const {
  return !sources_.empty() && std::all_of(sources_.begin(), sources_.end(), [](const auto& s) { return s->done(); });
}

FrontEndCounts DeviceFrontEnd::counts() const {
  FrontEndCounts c;
  for (const auto& s : sources_) {
    const SourceCounts k = s->counts();
    c.sources.samples += k.samples;
    c.sources.malformed += k.malformed;
    c.sources.lost += k.lost;
  }
  c.tracking = tracker_.counts();
  c.events = gestures_.events();
  c.events_lost = gestures_.events_lost();
  c.missed_presses = gestures_.missed_presses();
  c.other_devices = other_devices_;
  return c;
}

}  // namespace limberg
