#include "devices/front_end.h"

#include <algorithm>

#include "devices/force/tool_follower.h"

namespace limberg {

DeviceFrontEnd::DeviceFrontEnd(const Calibration& calibration, const GestureSettings& gestures)
    : tracker_(calibration), gestures_(gestures), glove_(calibration), hand_(calibration.glove) {}

void DeviceFrontEnd::add(std::unique_ptr<Source> source) { sources_.push_back(std::move(source)); }

void DeviceFrontEnd::tick(int64_t tick, const Snapshot& snapshot, EventSink& events, SampleSink& recorder,
                          ToolState& state) {
  tick_ = tick;
  snapshot_ = &snapshot;
  events_ = &events;
  recorder_ = &recorder;
  edges_ = 0;
  const int64_t now_ns = tick * kTickNs;
  for (const auto& source : sources_) {
    source->look(snapshot);
    if (auto* follower = dynamic_cast<ToolFollower*>(source.get())) follower->hold(gestures_.state());
    source->poll(now_ns, *this);
  }
  Pose pose = tracker_.at(now_ns);
  const Ground ground = acts_on_bone(Tool(gestures_.state().tool)) ? Ground::bone
                        : cursor_on_flesh_                         ? Ground::flesh
                                                                   : Ground::skin;
  if (cursor_on_) {
    cursor_.set_ground(ground);
    if (!cursor_.placed() && pose.valid) cursor_.put(snapshot, pose.tip_mm);
    cursor_.tick(snapshot, pose, clutch_ || clutch_button_, pressed_);
    if (cursor_.placed()) pose.tip_mm = cursor_.x_mm();
  }
  gestures_.tick(tick, pose, pressed_, edges_, snapshot, *this, clutch_);
  state = gestures_.state();
  if (have_glove_)
    hand_.tick(tick, glove_.at(now_ns), clutch_ || clutch_button_, snapshot, *this,
               ground == Ground::bone ? Ground::bone : Ground::skin);
  snapshot_ = nullptr;
  events_ = nullptr;
  recorder_ = nullptr;
}

void DeviceFrontEnd::on_sample(const Sample& sample) {
  recorder_->on_sample(sample);
  if (const auto* c = std::get_if<ControlSample>(&sample)) {
    last_sample_ns_ = std::max(last_sample_ns_, c->t_ns);
    gestures_.control(*c, tick_, *snapshot_, *this);
    if (c->kind == ControlSample::clutch) clutch_ = c->value[0] != 0;
    if (c->kind == ControlSample::cursor) {
      cursor_on_ = c->value[0] > 0;
      cursor_on_flesh_ = c->value[1] == 1;
      if (cursor_on_)
        cursor_.set_gain(c->value[0]);
      else
        cursor_.remove();
    }
  } else if (const auto* command = std::get_if<CommandSample>(&sample)) {
    last_sample_ns_ = std::max(last_sample_ns_, command->t_ns);
    gestures_.command(command->command, tick_, *snapshot_, *this);
  } else if (const auto* s = std::get_if<StylusSample>(&sample)) {
    last_sample_ns_ = std::max(last_sample_ns_, s->t_ns);
    add_stylus(*s, s->device_id);
  } else if (const auto* t = std::get_if<TrackerSample>(&sample)) {
    last_sample_ns_ = std::max(last_sample_ns_, t->t_ns);
    if (t->role == StationRole::stylus) add_stylus(as_stylus(*t), t->device_id);
    if (t->role == StationRole::forefinger || t->role == StationRole::thumb) have_glove_ = true, glove_.add(*t);
  }
}

void DeviceFrontEnd::add_stylus(const StylusSample& s, int32_t device) {
  if (!have_stylus_) {
    have_stylus_ = true;
    stylus_ = device;
  }
  if (device != stylus_) {
    ++other_devices_;
    return;
  }
  tracker_.add(s);
  const bool pressed = s.buttons & 1;
  if (pressed != pressed_) ++edges_;
  pressed_ = pressed;
  clutch_button_ = s.buttons & 2;
}

bool DeviceFrontEnd::push(const ToolEvent& event) {
  ToolEvent e = event;
  e.seq = next_event_++;
  return events_->push(e);
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
  c.events = next_event_;
  c.events_lost = gestures_.events_lost() + hand_.events_lost();
  c.glove = glove_.counts();
  c.grabs = hand_.grabs();
  c.empty_grabs = hand_.empty_grabs();
  c.missed_presses = gestures_.missed_presses();
  c.other_devices = other_devices_;
  return c;
}

}  // namespace limberg
