#include "app/window/input_router.h"

#include <algorithm>

namespace limberg {

namespace {
constexpr float kLiftPerNotch_mm = 1.5f;
constexpr double kHandGains[] = {1, 0.5, 0.25, 2};
constexpr double kCursorGains[] = {0, 1, 0.5, 0.25};
constexpr float kLead_px = 8, kLeadFinely_px = 1;
}  // namespace

/// Keys that lead the mouse: its place, or its left button.
bool InputRouter::lead(const WindowEvent& key) {
  const FrameSeen& seen = feed_.seen.reading();
  const DeskKey* k = key.kind == WindowEvent::key ? desk_key(key.code, key.mods) : nullptr;
  if (!k || (k->hand != HandKey::lead && k->hand != HandKey::press) || seen.typing || seen.popup) return false;
  if (seen.tour && k->hand == HandKey::press) return false;
  if (!key.down) return true;
  WindowEvent e;
  e.by_keys = true;
  if (k->hand == HandKey::lead) {
    const float step = key.mods & WindowEvent::shift ? kLeadFinely_px : kLead_px;
    const bool across = key.code == WindowEvent::arrow_left || key.code == WindowEvent::arrow_right;
    const bool back = key.code == WindowEvent::arrow_left || key.code == WindowEvent::arrow_up;
    e.x = std::clamp(x_ + (across ? back ? -step : step : 0), 0.0f, float(seen.width - 1));
    e.y = std::clamp(y_ + (across ? 0 : back ? -step : step), 0.0f, float(seen.height - 1));
  } else {
    led_press_ = !led_press_;
    e.kind = WindowEvent::button, e.code = 0, e.down = led_press_;
  }
  take(e);
  return true;
}

void InputRouter::take(const WindowEvent& event) {
  feed_.seen.update();
  if (lead(event)) return;
  if (event.kind == WindowEvent::button && event.code == 0 && !event.by_keys) led_press_ = false;
  const FrameSeen& seen = feed_.seen.reading();
  if (event.kind == WindowEvent::pointer) x_ = event.x, y_ = event.y;
  Happened h;
  h.event = event;
  h.ray.eye_mm = seen.view.eye_mm;
  h.ray.towards = seen.view.ray_through(x_, y_, seen.width, seen.height);
  h.on_panel = seen.on_panel(x_, y_);
  waiting_.push_back(h);
  hear_panels();
  go_on();
}

void InputRouter::pump(int64_t now_ns) {
  hear_panels();
  go_on();
  show(now_ns);
}

void InputRouter::send(const HandInput& input) {
  if (const auto* c = std::get_if<CommandSample>(&input)) told_.push_back(c->command);
  feed_.input.push(input);
}

void InputRouter::hear_panels() {
  for (PanelAnswer a; feed_.answers.pop(a);) {
    if (const auto* tool = std::get_if<HandChoice>(&a))
      choice_ = *tool, choose();
    else if (const auto* control = std::get_if<ControlSample>(&a))
      send(*control);
    else if (const auto* command = std::get_if<CommandSample>(&a))
      send(*command);
    else if (!feed_.showing)
      wanted_ = std::get<ShowActs>(a);
  }
}

void InputRouter::tell(const Command& command) { send(command_sample(command)); }

void InputRouter::go_on() {
  while (!waiting_.empty()) {
    if (feed_.answered.load(std::memory_order_acquire) < asked_) return;
    hear_panels();  // what was answered is there now
    feed_.seen.update();
    Happened h = waiting_.front();
    waiting_.pop_front();
    // A panel's slider follows the mouse as fast as frames are drawn: the places in between are passed over.
    const auto drags = [&](const Happened& x) {
      return x.event.kind == WindowEvent::pointer && (of_panel_[0] || of_panel_[1] || of_panel_[2]);
    };
    while (drags(h) && !waiting_.empty() && drags(waiting_.front())) h = waiting_.front(), waiting_.pop_front();
    decide(h);
  }
}

void InputRouter::decide(Happened& h) {
  WindowEvent& e = h.event;
  const FrameSeen& now = feed_.seen.reading();
  bool asks = false;  // panels may answer
  switch (e.kind) {
    case WindowEvent::pointer:
      asks = of_panel_[0] || of_panel_[1] || of_panel_[2];
      if (!asks) point(h);
      break;
    case WindowEvent::button: {
      bool& of_panel = of_panel_[e.code];
      if (e.down) of_panel = h.on_panel || (now.asks && e.code == 0 && mouse_);
      e.for_panels = of_panel;
      asks = of_panel || now.typing;  // a click anywhere ends the typing
      if (!e.down) of_panel = false;
      if (e.code != 0 || e.for_panels) break;
      pressed_ = e.down;
      if (e.down) lift_mm_ = 0;
      point(h);
      break;
    }
    case WindowEvent::wheel:
      e.for_panels = h.on_panel && !pressed_;
      if (!pressed_) break;
      lift_mm_ += kLiftPerNotch_mm * e.y;
      point(h);
      break;
    case WindowEvent::key: {
      const bool of_tour = now.tour && (e.code == WindowEvent::enter || e.code == WindowEvent::escape);
      const DeskKey* k = of_tour ? nullptr : desk_key(e.code, e.mods);
      e.for_panels = now.typing || of_tour;
      if (k && k->hand == HandKey::clutch && !e.down)
        key(*k, e);  // let go, whoever has the keys
      else if (k && k->hand != HandKey::none && !now.typing)
        e.for_hand = true, key(*k, e);
      else
        asks = e.down;
      break;
    }
    default:
      e.for_panels = now.typing;
      asks = now.typing || e.code == '?';  // which opens the help
      break;
  }
  e.number = ++number_;
  if (screen_.events.push(e) && asks) asked_ = e.number;
}

void InputRouter::key(const DeskKey& k, const WindowEvent& e) {
  const auto control = [&](ControlSample::Kind kind, double value = 0) {
    ControlSample c;
    c.kind = kind, c.value[0] = value;
    send(c);
  };
  if (k.hand == HandKey::clutch) {
    if (bool(e.down) == clutch_) return;  // a key that repeats
    clutch_ = e.down;
    control(ControlSample::clutch, clutch_);
    return;
  }
  if (!e.down) return;
  if (k.hand == HandKey::glove) {
    glove_cursor_ = !glove_cursor_;
    control(ControlSample::glove, glove_cursor_ ? kGlovePushesCursor : kGlovePoints);
  } else if (k.hand == HandKey::cursor) {
    cursor_ = (cursor_ + 1) % std::size(kCursorGains);
    control(ControlSample::cursor, kCursorGains[cursor_]);
  } else if (k.hand == HandKey::gain) {
    const bool back = e.mods & WindowEvent::shift;
    gain_ = back ? 0 : (gain_ + 1) % std::size(kHandGains);
    control(ControlSample::hand_gain, back ? 0 : kHandGains[gain_]);
  } else if (k.hand == HandKey::tool) {
    const Tool tool = tool_of_key(e.code, e.mods)->tool;
    if (tool == choice_.tool) return;
    choice_.tool = tool;
    choose();
  } else {
    const bool redo = k.hand == HandKey::redo || (e.mods & WindowEvent::shift);
    control(redo ? ControlSample::redo : ControlSample::undo);
  }
}

void InputRouter::choose() {
  if (!feed_.showing) send(control_of(choice_));  // else the hand that shows has the tool
}

void InputRouter::point(const Happened& h) {
  if (!mouse_) return;
  last_ = h.ray;
  last_.pressed = pressed_, last_.lift_mm = lift_mm_;
  last_.inside = pressed_ || !h.on_panel;
  if (!feed_.showing) send(last_);
}

/// Brackets around what is shown: it is not the learner's, in the recording too (sim/commands/authorship.h).
void InputRouter::begin_showing(const Snapshot& patient) {
  constexpr uint64_t kStepsOfUndo = 3;  // of the patient, until what was taken back is gone
  tell(Shown{true});
  ControlSample undo;
  undo.kind = ControlSample::undo;
  for (int i = 0; i < wanted_->undos; ++i) send(undo);
  acts_ = wanted_->acts;
  shown_after_ = patient.step + (wanted_->undos > 0 ? kStepsOfUndo : 0);
  wanted_.reset();
  feed_.showing = true;
  begun_ = false;
}

void InputRouter::show(int64_t now_ns) {
  const bool wanted = feed_.showing || wanted_;
  const Snapshot* patient = look_ ? look_(wanted) : nullptr;
  if (!patient || !patient->topology) return;
  if (wanted_ && !feed_.showing && !pressed_) begin_showing(*patient);
  if (!feed_.showing) return;
  if (!begun_) {
    if (patient->step < shown_after_) return;
    begun_ = true;
    if (acts_) shown_.begin(*acts_, now_ns, *patient);
  }
  struct Sink final : SampleSink {
    InputRouter& router;
    explicit Sink(InputRouter& r) : router(r) {}
    void on_sample(const Sample& s) override {
      if (const auto* c = std::get_if<ControlSample>(&s))
        router.send(*c);
      else if (const auto* command = std::get_if<CommandSample>(&s))
        router.send(*command);
      else
        router.send(std::get<StylusSample>(s));
    }
  } sink(*this);
  if (shown_.poll(now_ns, *patient, sink)) return;
  // The mouse has its own tool again.
  acts_.reset();
  tell(Shown{false});
  feed_.showing = false;
  choose();
  if (mouse_) send(last_);
}

}  // namespace limberg
