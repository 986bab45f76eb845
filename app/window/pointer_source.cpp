#include "app/window/pointer_source.h"

#include <algorithm>
#include <cmath>

#include "app/window/ray_cast.h"

namespace limberg {

namespace {
constexpr int64_t kRepeatNs = 12'000'000;  // a hand that rests is still there
}

void PointerSource::poll(int64_t now_ns, SampleSink& sink) {
  bool placed = false;
  for (HandInput i; !placed && feed_.input.pop(i);) {
    if (auto* c = std::get_if<ControlSample>(&i)) {
      if (c->kind == ControlSample::select_tool) tool_ = c->tool;
      c->device_id = kDevice, c->seq = control_seq_++, c->t_ns = now_ns;
      ++sent_;
      sink.on_sample(*c);
    } else if (auto* command = std::get_if<CommandSample>(&i)) {
      command->device_id = kDevice, command->seq = command_seq_++, command->t_ns = now_ns;
      ++sent_;
      sink.on_sample(*command);
    } else if (const auto* s = std::get_if<StylusSample>(&i)) {
      placed = true;
      if (now_ns > last_sent_ns_) hand_on(*s, now_ns, sink);
    } else {
      placed = true;
      take(std::get<PointerReading>(i), now_ns, sink);
    }
  }
  if (!placed && have_last_ && !feed_.showing && now_ns - last_sent_ns_ >= kRepeatNs) point(last_, now_ns, sink);
  seen_ = nullptr;
}

// A mouse that is read more often than a tick is followed by every second place: what has waited is caught up with, and
// a stroke keeps its shape. A change of the button is never passed over.
void PointerSource::take(const PointerReading& reading, int64_t now_ns, SampleSink& sink) {
  PointerReading r = reading;
  if (const HandInput* next = feed_.input.front())
    if (const auto* n = std::get_if<PointerReading>(next); n && n->pressed == r.pressed && r.pressed == last_.pressed)
      r = *n, feed_.input.drop();
  last_ = r, have_last_ = true;
  point(r, now_ns, sink);
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
  s.tip_mm = tip_mm.cast<double>();
  const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), shaft.cast<double>());
  s.quat = {q.w(), q.x(), q.y(), q.z()};
  s.buttons = pressed ? 1 : 0;
  pressed_ = pressed;
  hand_on(s, now_ns, sink);
}

void PointerSource::hand_on(StylusSample s, int64_t now_ns, SampleSink& sink) {
  s.device_id = kDevice, s.seq = stylus_seq_++, s.t_ns = last_sent_ns_ = now_ns;
  ++sent_;
  sink.on_sample(s);
}

}  // namespace limberg
