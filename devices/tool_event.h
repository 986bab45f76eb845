#pragma once
// What a gesture means, on its way from the device thread to the solver thread (SPSC ring): of fixed size, but for the
// command of a panel, which is kept by who made it.
#include <cstdint>

#include "devices/missed_press.h"
#include "devices/sample.h"

namespace limberg {

struct ToolEvent {
  enum Kind : int32_t {
    stroke_begin,
    stroke_point,
    stroke_end,
    stroke_cancel,  // what is drawn; two strokes make a row of stitches
    hook_set,
    hook_release,
    suture_a,
    suture_b,
    undo,
    stage,
    hook_take,   // an existing hook is gripped again at its handle; it follows the hand from now on
    hook_leave,  // the hand lets go; the hook's handle stays at world_mm
    suture_cancel,
    redo,
    suture_cut,  // the scissors close at the touched point
    // the hand closes on a fragment at rest_mm; it follows ToolState::carried or SecondHand::carried from now on
    bone_grab,
    bone_drag,  // where the fragment was taken in the end: world_mm and quat, the map of places since it was grabbed
    bone_release,
    name_place,    // of a head: rest_mm has the name `text` from now on; id 1: on the face
    told,          // what a panel or a program says: `command`; without one it says nothing yet
    suture_tip,    // of a corner's stitch: between suture_a and suture_b, the needle goes through the flap's tip
    suture_knot,   // the thread that is sewn bite after bite is tied
    suture_let_go  // ... is let go: the hand takes another tool
  };
  int64_t seq = 0;        // counts events, gaps are losses
  int64_t tick = 0;       // device tick, 1 ms
  uint64_t snapshot = 0;  // the snapshot step it was made on
  int32_t kind = stroke_point;
  int32_t tool = 0;                 // Tool
  double chart_x = 0, chart_y = 0;  // the touched skin point, rest chart mm
  double world_mm[3]{};
  double rest_mm[3]{};  // the touched place at rest
  // At rest, unit: out of the skin there; of a cut right through, the way from the blade to the hand.
  double out[3]{0, 0, 1};
  double seen_mm[3]{};  // and where it was, as the hand was shown it
  double quat[4]{1, 0, 0, 0};
  // angle_deg of a cut right through: 0 where the blade goes as it is held, else across the skin
  double depth_mm = 0, angle_deg = 90, spacing_mm = 0;
  int32_t id = 0;    // hook id, or stage number
  int32_t hand = 0;  // 0 stylus, 1 glove
  int32_t side = 0;  // HeldSide: of a bite, what the needle goes into
  ShortText text;    // stage: its name
  std::shared_ptr<const Command> command;
};

/// Where tool events go. False: the sink is full and the event is lost (the caller counts it).
class EventSink {
 public:
  virtual ~EventSink() = default;
  virtual bool push(const ToolEvent& event) = 0;
  /// A press came to nothing. Not an event: it changes nothing, and recordings do not have it.
  virtual void missed(const MissedPress& press) { (void)press; }
};

/// A fragment of bone in a hand: a map of places, from where they were when it was grabbed to where the hand takes
/// them.
struct Carried {
  int32_t holds = 0;  // counts grabs of this hand; 0: nothing is held
  double quat[4]{1, 0, 0, 0};
  double shift_mm[3]{};
};

/// The newest tool state (triple buffer): where the hand is now. Hooks that are held follow it.
struct ToolState {
  int64_t tick = 0;
  double tip_mm[3]{};
  double shaft[3]{0, 0, 1};
  int32_t tool = 0;
  int32_t held_hook = 0;  // 0 = none
  int32_t pressed = 0;
  int32_t bites = 0;  // a stitch is begun: so many bites of it are taken, the places of the last two are
  double bite_mm[2][3]{};
  int32_t valid = 0;  // 0 before the first sample or when stale
  double
      shift_mm[3]{};  // of what is held and of the tip with it, from where the hand is: what the clutch has left behind
  Carried carried;
};

}  // namespace limberg
