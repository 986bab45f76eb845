#include "devices/front_end.h"

#include <algorithm>

#include "devices/force/tool_follower.h"

namespace limberg {

DeviceFrontEnd::DeviceFrontEnd(const Calibration& calibration, const GestureSettings& gestures)
    : tracker_(calibration),
      gestures_(gestures),
      glove_{GloveHand(calibration, calibration.glove, 1),
             GloveHand(calibration, calibration.other_glove.value_or(calibration.glove), 2)} {}

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
  for (GloveHand& g : glove_) g.read(now_ns);
  pass_tool();
  const Ground ground = acts_on_bone(Tool(gestures_.state().tool)) ? Ground::bone
                        : cursor_on_flesh_                         ? Ground::flesh
                                                                   : Ground::skin;
  const bool clutch = clutch_ || clutch_button_;
  const Pose stylus = stylus_pose(now_ns, snapshot, ground);
  if (tool_hand_ == 0) {
    gestures_.tick(tick, stylus, pressed_, edges_, snapshot, *this, clutch_);
  } else {
    GloveHand& g = glove_[tool_hand_ - 1];
    gestures_.tick(tick, g.push_cursor(snapshot, ground, clutch), g.pressed(), g.edges(), snapshot, *this, clutch_);
  }
  state = gestures_.state();
  for (size_t i = 0; i < glove_.size(); ++i)
    glove_[i].act(tick, tool_hand_ == i + 1, clutch, snapshot, *this,
                  ground == Ground::bone ? Ground::bone : Ground::skin);
  snapshot_ = nullptr;
  events_ = nullptr;
  recorder_ = nullptr;
}

Pose DeviceFrontEnd::stylus_pose(int64_t now_ns, const Snapshot& s, Ground ground) {
  Pose pose = tracker_.at(now_ns);
  if (!cursor_on_ || tool_hand_ != 0) return pose;
  cursor_.set_ground(ground);
  if (!cursor_.placed() && pose.valid) cursor_.put(s, pose.tip_mm);
  cursor_.tick(s, pose, clutch_ || clutch_button_, pressed_);
  if (cursor_.placed()) pose.tip_mm = cursor_.x_mm();
  return pose;
}

/// The tool goes from hand to hand when neither does anything.
void DeviceFrontEnd::pass_tool() {
  if (wanted_hand_ == tool_hand_ && !cursor_anew_) return;
  const auto idle = [&](size_t hand) {
    return hand == 0 ? !pressed_ : glove_[hand - 1].seen() && glove_[hand - 1].free();
  };
  if (!idle(tool_hand_) || !idle(wanted_hand_)) return;
  tool_hand_ = wanted_hand_, cursor_anew_ = false;
  if (tool_hand_ > 0) glove_[tool_hand_ - 1].take_tool();
}

void DeviceFrontEnd::control(const ControlSample& c) {
  const size_t which = c.value[kWhichGlove] > 0 ? 1 : 0;
  switch (c.kind) {
    case ControlSample::clutch:
      clutch_ = c.value[0] != 0;
      break;
    case ControlSample::cursor:
      cursor_on_ = c.value[0] > 0;
      cursor_on_flesh_ = c.value[1] == 1;
      if (cursor_on_)
        cursor_.set_gain(c.value[0]);
      else
        cursor_.remove();
      break;
    case ControlSample::glove:
      if (int(c.value[kGloveMode]) == kGlovePushesCursor)
        wanted_hand_ = which + 1, cursor_anew_ = true;
      else if (wanted_hand_ == which + 1)
        wanted_hand_ = 0;
      if (c.value[kCursorGain] > 0) glove_[which].set_cursor_gain(c.value[kCursorGain]);
      break;
    case ControlSample::stylus:
      follow(int32_t(c.value[0]));
      break;
    case ControlSample::hand_gain:
      glove_[which].set_gain(c.value[0]);
      break;
    default:
      break;
  }
}

void DeviceFrontEnd::on_sample(const Sample& sample) {
  recorder_->on_sample(sample);
  if (const auto* c = std::get_if<ControlSample>(&sample)) {
    last_sample_ns_ = std::max(last_sample_ns_, c->t_ns);
    gestures_.control(*c, tick_, *snapshot_, *this);
    control(*c);
  } else if (const auto* command = std::get_if<CommandSample>(&sample)) {
    last_sample_ns_ = std::max(last_sample_ns_, command->t_ns);
    gestures_.command(command->command, tick_, *snapshot_, *this);
  } else if (const auto* s = std::get_if<StylusSample>(&sample)) {
    last_sample_ns_ = std::max(last_sample_ns_, s->t_ns);
    add_stylus(*s, s->device_id);
  } else if (const auto* t = std::get_if<TrackerSample>(&sample)) {
    last_sample_ns_ = std::max(last_sample_ns_, t->t_ns);
    if (t->role == StationRole::stylus) add_stylus(as_stylus(*t), t->device_id);
    if (t->role == StationRole::forefinger || t->role == StationRole::thumb) glove_[0].add(t->role, *t);
    if (t->role == StationRole::other_forefinger) glove_[1].add(StationRole::forefinger, *t);
    if (t->role == StationRole::other_thumb) glove_[1].add(StationRole::thumb, *t);
  }
}

void DeviceFrontEnd::follow(int32_t device) {
  if (have_stylus_ && device == stylus_) return;
  have_stylus_ = device != 0, stylus_ = device;
  tracker_.begin_anew();
  if (pressed_) ++edges_;
  pressed_ = clutch_button_ = false;
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
  c.events_lost = gestures_.events_lost();
  c.glove = glove_[0].counts();
  for (const GloveHand& g : glove_) {
    c.events_lost += g.hand().events_lost();
    c.grabs += g.hand().grabs();
    c.empty_grabs += g.hand().empty_grabs();
  }
  c.missed_presses = gestures_.missed_presses();
  c.other_devices = other_devices_;
  return c;
}

}  // namespace limberg
