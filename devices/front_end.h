#pragma once
// The device side, one object, driven tick by tick: read sources -> filter -> gestures on the newest snapshot. A stylus
// in one hand and a glove on the other work at the same time (virtual_hand.h); while a glove is closed, a second button
// of the stylus (bit 1) is its clutch.
//
// ControlSample::clutch (a key, a pedal) is the clutch of both hands: while it is down they move and what they hold
// does not; afterwards it follows from where it is. Whatever device has sent the last one counts.
//
// A glove either points and grabs, or has the tool and pushes the surface cursor with its forefinger
// (ControlSample::glove, glove_hand.h): then it cuts, and the stylus rests. ControlSample::hand_gain says how far its
// hand goes in the scene. There may be two gloves (StationRole::other_forefinger, other_thumb), with a fragment each.
//
// The first stylus that sends is followed, and no other beside it; ControlSample::stylus names another one (a headset
// was put on, or off). What is pressed then is let go.
//
// With the surface cursor on (ControlSample::cursor) the stylus pushes a place of the skin about instead of being there
// (surface_cursor.h); every tool then acts at that place, and the second button is the clutch.
//
//   DeviceFrontEnd front(calibration);
//   front.add(std::make_unique<LogSource>(...));
//   for (int64_t tick = 0;; ++tick)                       // 1 ms each; a real-time thread or a virtual clock
//     front.tick(tick, newest_snapshot, events, recorder, tool_state);
//
// It knows no thread and no clock. The same ticks with the same samples and snapshots give the same events, bit for
// bit.
// A tick allocates nothing, as long as its sources do not and somebody has asked the topology for its indices before
// (ground_index.h; a session's solver lane does).
#include <cstdint>
#include <memory>
#include <vector>

#include "calibration/calibration.h"
#include "devices/gestures.h"
#include "devices/glove_hand.h"
#include "devices/source.h"
#include "devices/surface_cursor.h"
#include "devices/tool_event.h"
#include "devices/tracking.h"
#include "devices/virtual_hand.h"

namespace limberg {

struct FrontEndCounts {
  SourceCounts sources;  // summed
  TrackingCounts tracking;
  int64_t events = 0, events_lost = 0, missed_presses = 0;
  int64_t other_devices = 0;  // stylus samples of a second device, recorded but not followed
  GloveCounts glove;
  int64_t grabs = 0, empty_grabs = 0;
};

class DeviceFrontEnd final : private SampleSink, private EventSink {
 public:
  static constexpr int64_t kTickNs = 1'000'000;

  explicit DeviceFrontEnd(const Calibration& calibration, const GestureSettings& gestures = {});
  void add(std::unique_ptr<Source> source);

  /// Device tick number `tick` (time tick * kTickNs; must grow, may skip). Hands every raw sample to `recorder` as
  /// received, pushes tool events to `events`, sets `state` to the hand's newest state. A snapshot without topology
  /// (nothing to touch yet) is allowed.
  void tick(int64_t tick, const Snapshot& snapshot, EventSink& events, SampleSink& recorder, ToolState& state);

  bool done() const;                                          // every source has ended, and there is at least one
  int64_t last_sample_ns() const { return last_sample_ns_; }  // time stamp of the newest sample handled; -1 before any
  FrontEndCounts counts() const;
  const SkinTouch& touched() const { return gestures_.touched(); }
  /// The gloves' hands (0 the first, 1 the other one); nothing is computed for one before it has been seen.
  const SecondHand& second_hand(size_t glove = 0) const { return glove_[glove].hand().state(); }
  const VirtualHand& hand(size_t glove = 0) const { return glove_[glove].hand(); }
  const GloveHand& glove(size_t which) const { return glove_[which]; }
  /// Which hand has the tool: 0 the stylus', 1 the first glove, 2 the other one.
  size_t tool_hand() const { return tool_hand_; }
  const SurfaceCursor& cursor() const { return cursor_; }

 private:
  void on_sample(const Sample& sample) override;
  bool push(const ToolEvent& event) override;  // numbers the events of both hands
  void missed(const MissedPress& press) override { events_->missed(press); }
  void add_stylus(const StylusSample& s, int32_t device);
  void follow(int32_t device);
  void control(const ControlSample& c);
  void pass_tool();
  Pose stylus_pose(int64_t now_ns, const Snapshot& s, Ground ground);

  std::vector<std::unique_ptr<Source>> sources_;
  StylusTracker tracker_;
  Gestures gestures_;
  std::array<GloveHand, 2> glove_;
  size_t tool_hand_ = 0, wanted_hand_ = 0;
  bool cursor_anew_ = false;
  SurfaceCursor cursor_;
  bool cursor_on_ = false, cursor_on_flesh_ = false;
  int64_t next_event_ = 0;
  bool have_stylus_ = false, pressed_ = false;
  bool clutch_button_ = false, clutch_ = false;  // the stylus' second button; ControlSample::clutch
  int32_t stylus_ = 0;
  int edges_ = 0;
  int64_t other_devices_ = 0, last_sample_ns_ = -1;
  // Valid during tick() only.
  int64_t tick_ = 0;
  const Snapshot* snapshot_ = nullptr;
  EventSink* events_ = nullptr;
  SampleSink* recorder_ = nullptr;
};

}  // namespace limberg
