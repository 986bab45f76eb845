#pragma once
// The mouse as a device: like a stylus whose tip is the point of the patient under the pointer, so that gestures,
// recording and replay need to know nothing of a mouse.
//
// Everything comes from one ring, in the order in which the person did it (hand_feed.h). A choice takes effect on the
// tick on which it is handed on, a reading at its end; so a tick takes choices, and then at most one place of the
// mouse.
//
// The left button engages the chosen tool. A hook that is held moves in the plane of the screen through the place where
// it was set; the wheel lifts it towards the eye.
#include "app/window/hand_feed.h"
#include "devices/source.h"

namespace limberg {

class PointerSource final : public Source {
 public:
  static constexpr int32_t kDevice = 50;
  /// `stays`: the session goes on until the window is closed; else it may end with the other devices.
  explicit PointerSource(HandFeed& feed, bool stays = true) : feed_(feed), stays_(stays) {}
  void look(const Snapshot& snapshot) override { seen_ = &snapshot; }
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override { return !stays_; }
  SourceCounts counts() const override { return {sent_, 0, int64_t(feed_.input.lost())}; }

 private:
  void take(const PointerReading& reading, int64_t now_ns, SampleSink& sink);
  void point(const PointerReading& reading, int64_t now_ns, SampleSink& sink);
  void send(const Vec3f& tip_mm, const Vec3f& shaft, bool pressed, int64_t now_ns, SampleSink& sink);
  void hand_on(StylusSample s, int64_t now_ns, SampleSink& sink);

  HandFeed& feed_;
  bool stays_;
  const Snapshot* seen_ = nullptr;
  PointerReading last_;
  bool have_last_ = false, pressed_ = false;
  Tool tool_ = Tool::none;
  Vec3f grip_mm_ = Vec3f::Zero(), grip_normal_ = Vec3f::UnitZ(), tip_mm_ = Vec3f::Zero(), shaft_ = Vec3f::UnitZ();
  int64_t last_sent_ns_ = -1, stylus_seq_ = 0, control_seq_ = 0, command_seq_ = 0, sent_ = 0;
};

}  // namespace limberg
