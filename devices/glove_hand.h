#pragma once
// One glove, from its two stations to what its hand does in the scene. It does one of two things:
//
//   points   the virtual hand (virtual_hand.h): points, grabs, carries, lets go
//   cursor   the chosen tool is in this hand. The surface cursor (surface_cursor.h) is put where the forefinger points;
//            what the forefinger's tip travels pushes it. Thumb and forefinger that close hold the pen: the tool is
//            pressed until they open. While they close or open the cursor stays: the fingers bend, and nothing is
//            meant by that.
//
// It goes from one to the other when it is open and holds nothing, so that nothing is dropped. Which hand has the tool
// is the front end's to say (front_end.h).
#include "devices/hand_gain.h"
#include "devices/surface_cursor.h"
#include "devices/virtual_hand.h"

namespace limberg {

class GloveHand {
 public:
  /// `number`: 1 the first glove, 2 the other one.
  GloveHand(const Calibration& calibration, const GloveParameters& glove, int32_t number);

  void add(StationRole as, TrackerSample reading);
  bool seen() const { return seen_; }
  void set_gain(double gain);  // 0: where it is in the room again, once it holds nothing
  double gain() const { return gain_.gain(); }
  void set_cursor_gain(double gain) { cursor_.set_gain(gain); }

  /// First in a tick: where the hand is now.
  void read(int64_t now_ns);
  /// Open, and nothing in it.
  bool free() const;
  bool closed() const { return hand_.closed; }

  /// The tool comes into this hand, or goes from it; the cursor is put anew.
  void take_tool() { cursor_.remove(), opening_ = {}; }
  /// The cursor follows; the pose of the tool, which is at the cursor.
  Pose push_cursor(const Snapshot& s, Ground ground, bool clutch);
  /// Whether the tool is pressed, and how often that has changed since the last tick.
  bool pressed() const { return hand_.closed; }
  int edges() const { return hand_.closed != was_closed_; }

  /// Last in a tick: the hand points, or is only shown.
  void act(int64_t tick, bool has_tool, bool clutch, const Snapshot& s, EventSink& out, Ground ground);

  const VirtualHand& hand() const { return virtual_; }
  const SurfaceCursor& cursor() const { return cursor_; }
  GloveCounts counts() const { return tracker_.counts(); }

 private:
  GloveTracker tracker_;
  HandGain gain_;
  VirtualHand virtual_;
  SurfaceCursor cursor_;
  OpeningRate opening_;
  HandPose hand_;
  bool seen_ = false, was_closed_ = false, reset_gain_ = false;
};

}  // namespace limberg
