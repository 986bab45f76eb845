#pragma once
// The mouse as a device: like a stylus whose tip is the point of the patient under the pointer, so that gestures,
// recording and replay need to know nothing of a mouse.
//
//   main thread    pointer readings (where the ray starts and goes, left button) ──ring──┐
//   render thread  choices of the palette, "show me the next step" ──────────────ring──┤──► PointerSource (device
//   thread)
//
// The left button engages the chosen tool. A hook that is held moves in the plane of the screen through the place where
// it was set; the wheel lifts it towards the eye. "Next" has the lesson's next step shown by an emulated hand.
#include <atomic>
#include <memory>
#include <vector>

#include "devices/spsc_ring.h"
#include "app/session/triple_buffer.h"
#include "devices/emulator.h"
#include "devices/source.h"
#include "render/view.h"

namespace limberg {

struct PointerReading {
  Vec3f eye_mm = Vec3f::Zero(), towards = -Vec3f::UnitZ();
  float lift_mm = 0;  // of a held hook, towards the eye
  int32_t pressed = 0;
  int32_t inside = 1;  // 0: the pointer is over a panel or outside
};

/// What main and render thread have to say to the device thread, and to one another.
struct PointerFeed {
  SpscRing<PointerReading> readings{1 << 10};  // main -> device
  SpscRing<ControlSample> choices{1 << 6};     // render -> device; its time is set there
  std::atomic<bool> keep_recording{false};     // render -> main
  std::atomic<int> next_wanted{0};             // render -> device: so many steps of the lesson asked for
  std::atomic<int> next_shown{0};              // device -> render: so many were begun
  std::atomic<bool> showing{false};            // device -> render: a step is being shown
  struct Sight {
    View view;
    int width = 1, height = 1;
  };
  TripleBuffer<Sight> sight;                     // render -> main
  std::atomic<bool> panels_have_pointer{false};  // render -> main
};

/// The main thread's half: window events into readings.
class PointerReader {
 public:
  explicit PointerReader(PointerFeed& feed) : feed_(feed) {}
  void pointer(float x_px, float y_px);
  void left_button(bool down);
  void wheel(float notches);  // while the button is down: lifts

 private:
  void send();
  PointerFeed& feed_;
  PointerReading now_;
  float x_ = 0, y_ = 0;
};

/// The steps of a lesson as they are shown one at a time: an act, and the rests and stages that follow it. Pieces of
/// one stroke are one act.
std::vector<std::vector<Command>> lesson_steps(const std::vector<Command>& script);

class PointerSource final : public Source {
 public:
  static constexpr int32_t kDevice = 50;
  /// `lesson`: the steps that "next" shows, one after another; may be empty. `stays`: the session goes on until the
  /// window is closed; else it may end with the other devices.
  PointerSource(PointerFeed& feed, const std::vector<std::vector<Command>>& lesson, bool stays = true);
  void look(const Snapshot& snapshot) override { seen_ = &snapshot; }
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override { return !stays_; }
  SourceCounts counts() const override { return {sent_, 0, int64_t(feed_.readings.lost() + feed_.choices.lost())}; }

 private:
  class Forward;
  bool show(int64_t now_ns, SampleSink& sink);
  void point(const PointerReading& reading, int64_t now_ns, SampleSink& sink);
  void send(const Vec3f& tip_mm, const Vec3f& shaft, bool pressed, int64_t now_ns, SampleSink& sink);

  PointerFeed& feed_;
  std::vector<std::vector<Command>> lesson_;
  std::unique_ptr<Source> hand_;  // that shows the step being shown
  bool stays_;
  size_t shown_ = 0;
  int64_t began_ns_ = -1;  // of the step being shown
  const Snapshot* seen_ = nullptr;
  PointerReading last_;
  bool have_last_ = false, pressed_ = false;
  Tool tool_ = Tool::none;
  Vec3f grip_mm_ = Vec3f::Zero(), grip_normal_ = Vec3f::UnitZ(), tip_mm_ = Vec3f::Zero(), shaft_ = Vec3f::UnitZ();
  int64_t last_sent_ns_ = -1, stylus_seq_ = 0, control_seq_ = 0, sent_ = 0;
};

}  // namespace limberg
