#include "app/window/pointer_source.h"

#include <algorithm>
#include <cmath>

#include "app/window/ray_cast.h"
#include "devices/head_surgeon.h"
#include "sim/commands/strokes.h"

namespace limberg {

namespace {

constexpr int64_t kRepeatNs = 12'000'000;  // a hand that rests is still there
constexpr float kLiftPerNotch_mm = 1.5f;

SurgeonSettings steady_hand() {
  SurgeonSettings s;
  s.noise_mm = s.noise_rad = s.tremor_mm = 0;
  s.dropouts_per_s = 0;
  s.start_s = 0.15, s.settle_s = 0.2;
  s.device_id = PointerSource::kDevice;
  return s;
}

}  // namespace

void PointerReader::pointer(float x_px, float y_px) {
  x_ = x_px, y_ = y_px;
  send();
}

void PointerReader::left_button(bool down) {
  if (down && feed_.panels_have_pointer.load()) return;
  now_.pressed = down;
  if (down) now_.lift_mm = 0;
  send();
}

void PointerReader::wheel(float notches) {
  if (!now_.pressed) return;
  now_.lift_mm += kLiftPerNotch_mm * notches;
  send();
}

void PointerReader::send() {
  feed_.sight.update();
  const PointerFeed::Sight& s = feed_.sight.reading();
  now_.eye_mm = s.view.eye_mm;
  now_.towards = s.view.ray_through(x_, y_, s.width, s.height);
  now_.inside = now_.pressed || !feed_.panels_have_pointer.load();
  feed_.readings.push(now_);
}

std::vector<std::vector<Command>> lesson_steps(const std::vector<Command>& script) {
  std::vector<std::vector<Command>> steps;
  for (const Command& c : join_strokes(script)) {
    const bool follows = std::holds_alternative<Wait>(c) || std::holds_alternative<Stage>(c);
    if (steps.empty() || !follows) steps.emplace_back();
    steps.back().push_back(c);
  }
  return steps;
}

PointerSource::PointerSource(PointerFeed& feed, const std::vector<std::vector<Command>>& lesson, bool stays)
    : feed_(feed), lesson_(lesson), stays_(stays) {}

// Samples of the hand that shows, renumbered and on the session's clock.
class PointerSource::Forward final : public SampleSink {
 public:
  Forward(PointerSource& owner, int64_t began_ns, SampleSink& to) : owner_(owner), began_ns_(began_ns), to_(to) {}
  void on_sample(const Sample& sample) override {
    ++owner_.sent_;
    if (const auto* c = std::get_if<ControlSample>(&sample)) {
      ControlSample out = *c;
      if (out.kind == ControlSample::select_tool) owner_.tool_ = out.tool;
      out.seq = owner_.control_seq_++, out.t_ns += began_ns_;
      to_.on_sample(out);
    } else {
      StylusSample out = std::get<StylusSample>(sample);
      out.seq = owner_.stylus_seq_++, out.t_ns += began_ns_;
      owner_.last_sent_ns_ = out.t_ns;
      to_.on_sample(out);
    }
  }

 private:
  PointerSource& owner_;
  int64_t began_ns_;
  SampleSink& to_;
};

bool PointerSource::show(int64_t now_ns, SampleSink& sink) {
  if (began_ns_ < 0 && shown_ < lesson_.size() && feed_.next_wanted.load() > int(shown_) && !pressed_ && seen_ &&
      seen_->topology) {
    // What acts on bone, and everything where there is no skin, is shown by the hand for bone: with the stylus, as the
    // mouse is one.
    const std::vector<Command>& step = lesson_[shown_];
    const bool bone = !seen_->topology->body || std::any_of(step.begin(), step.end(), [](const Command& c) {
      return std::holds_alternative<HeadCommand>(c);
    });
    if (bone)
      hand_ = std::make_unique<EmulatedHeadSurgeon>(step, steady_hand(), HeadHands::stylus);
    else
      hand_ = std::make_unique<EmulatedSurgeon>(step, steady_hand());
    began_ns_ = now_ns + 1;
    ++shown_;
    feed_.next_shown.store(int(shown_));
    feed_.showing.store(true);
  }
  if (began_ns_ < 0) return false;
  Source& hand = *hand_;
  if (seen_) hand.look(*seen_);
  Forward forward(*this, began_ns_, sink);
  if (now_ns >= began_ns_) hand.poll(now_ns - began_ns_, forward);
  if (hand.done()) {
    began_ns_ = -1;
    feed_.showing.store(false);
  }
  return true;
}

void PointerSource::poll(int64_t now_ns, SampleSink& sink) {
  for (ControlSample c; feed_.choices.pop(c);) {
    if (c.kind == ControlSample::select_tool) tool_ = c.tool;
    c.device_id = kDevice, c.seq = control_seq_++, c.t_ns = now_ns;
    ++sent_;
    sink.on_sample(c);
  }
  if (show(now_ns, sink)) {
    for (PointerReading r; feed_.readings.pop(r);) last_ = r;  // the hand that shows has the tool
    return;
  }
  // One reading a tick; a change of the button is never passed over.
  PointerReading r;
  bool fresh = false;
  while (feed_.readings.pop(r)) {
    fresh = true;
    if (r.pressed != last_.pressed) break;
  }
  if (fresh) last_ = r, have_last_ = true;
  if (fresh || (have_last_ && now_ns - last_sent_ns_ >= kRepeatNs)) point(last_, now_ns, sink);
  seen_ = nullptr;
}

void PointerSource::point(const PointerReading& r, int64_t now_ns, SampleSink& sink) {
  if (!seen_ || !seen_->topology || now_ns <= last_sent_ns_) return;
  const bool carries = tool_ == Tool::hook || tool_ == Tool::grab;
  if (pressed_ && r.pressed && carries) {
    const float slope = r.towards.dot(grip_normal_);
    if (std::abs(slope) > 1e-3f)
      tip_mm_ = r.eye_mm + (grip_mm_ - r.eye_mm).dot(grip_normal_) / slope * r.towards + r.lift_mm * grip_normal_;
    send(tip_mm_, shaft_, true, now_ns, sink);
    return;
  }
  const RayHit hit = r.inside ? cast_ray(*seen_, r.eye_mm, r.towards, acts_on_bone(tool_)) : RayHit{};
  if (hit.triangle < 0) {
    if (pressed_ && !r.pressed) send(tip_mm_, shaft_, false, now_ns, sink);  // let go beside the patient
    return;
  }
  if (r.pressed && !pressed_) grip_mm_ = hit.x_mm, grip_normal_ = -r.towards;
  shaft_ = (0.6f * hit.normal - 0.4f * r.towards).normalized();
  // What is carried is let go where it is, not on what lies behind it.
  const bool hangs = pressed_ && !r.pressed && carries;
  if (!hangs) tip_mm_ = hit.x_mm;
  send(tip_mm_, shaft_, r.pressed != 0, now_ns, sink);
}

void PointerSource::send(const Vec3f& tip_mm, const Vec3f& shaft, bool pressed, int64_t now_ns, SampleSink& sink) {
  StylusSample s;
  s.device_id = kDevice, s.seq = stylus_seq_++, s.t_ns = now_ns;
  s.tip_mm = tip_mm.cast<double>();
  const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), shaft.cast<double>());
  s.quat = {q.w(), q.x(), q.y(), q.z()};
  s.buttons = pressed ? 1 : 0;
  pressed_ = pressed;
  last_sent_ns_ = now_ns;
  ++sent_;
  sink.on_sample(s);
}

}  // namespace limberg
