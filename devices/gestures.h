#pragma once
// What the hand means: a pose, a button and a chosen tool, set against the newest patient, become tool events.
//
//   scalpel            press on the skin, draw, let go: a stroke; the touched points are material points (rest chart)
//   scalpel_through    the same; the blade goes right through, the way the hand holds it
//   undermine, excise  the same; the stroke is the outline. Pressed and let go in one place, excise takes out the
//                      loose piece that is touched
//   suture_row         two strokes, one along each edge; on the skin that stays nearest along the whole of it. The same
//                      tool taken again after the first begins anew
//   suture_running     the same; one thread
//   hook               press on the skin: a hook is set and follows the hand until the button is let go; press at the
//                      handle of a hook that stands: it is taken again
//   hook_out           press at a hook or at its handle: it is taken out
//   suture             press at a, let go at b: on other skin than that around a, if there is some under the tip
//   suture_buried      the same; the bites lie in the wound's walls
//   suture_corner      press on a bank, let go in the flap's tip, press on the other bank
//   suture_bites       the same; each stitch goes on with the thread of the one before
//   suture_knot        press beside the last bite of that thread: it is tied there
//                      A hand that takes another tool, but the swab, lets go of a thread that is not tied
//   suture_row_buried  two strokes, as of a row; the bites lie in the wound's walls
//   suture_deep        press at a, let go at b: each on skin or on a cut face, a flap's underside, its bed, a wall
//   scissors           press beside a stitch: its thread is cut; press at an edge of the wound, draw, let go: a cut
//   marker, swab       press on the skin, draw, let go: a line of the pen; what is wiped off
//   saw                press on bone, draw once round, let go: the closed line of an osteotomy
//   grab               press on bone: its fragment is carried, and turned about the tip, until the button is let go
//
// Where a hand rests before it presses or lets go, the mean of its last tenth of a second is meant: one period of
// tremor.
//
// A stroke that loses its tracking waits; when tracking does not come back soon and near, the stroke is cancelled.
#include <array>
#include <cstdint>

#include "devices/edge_stroke.h"
#include "devices/old_controls.h"
#include "devices/rigid_grip.h"
#include "devices/sample.h"
#include "devices/surface_index.h"
#include "devices/tool_event.h"
#include "devices/tracking.h"

namespace limberg {

struct GestureSettings {
  double reach_mm = 3;         // the tip touches skin that is nearer than this
  double lift_mm = 8;          // a stroke ends when the tip is further away than this
  double step_mm = 0.4;        // stroke points are at least this far apart on the skin (rest chart)
  double handle_reach_mm = 5;  // a press this near to a hook's handle takes it
  double resume_ms = 1000;     // a stroke outlives a gap in tracking of at most this
  double resume_mm = 8;        // ... if the hand comes back within this distance
  double stitch_mm = 5;        // scissors cut a thread that is this near, as the patient picks one
  double edge_mm = 3;          // ... else tissue, from an edge of a wound that is this near
  double knot_mm = 6;          // a thread is tied by a press that is this near to its last bite
  double apart_mm = 1.5;       // a stitch's second place is sought so far from the tip on other skin than the first
  double rest_mm = 0.8;        // a hand that stayed within this for a tenth of a second rests
  double default_depth_mm = 4, default_spacing_mm = 4;
  bool threads_slip = true;  // false, of recordings before there was suture_let_go: a thread is held by nobody
  // How far a stroke has come is measured on the skin in space, not on the chart, which sees steep skin shortened, and
  // of several sheets a press means the one that is exactly nearest; false of recordings from before.
  bool in_space = true;
  // A row's second edge is not on the skin of its first while there is other skin as near; false of recordings from
  // before.
  bool as_meant = true;
};

class Gestures {
 public:
  explicit Gestures(const GestureSettings& settings = {}) : g_(settings) {}

  /// A control, in the order of its arrival among the tick's samples.
  void control(const ControlSample& c, int64_t tick, const Snapshot& s, EventSink& out);
  /// A command that a panel or a program has made. What the hand is doing is broken off, unless only a name, a
  /// superposition or tissue between face and bone is spoken of.
  void command(const std::shared_ptr<const Command>& c, int64_t tick, const Snapshot& s, EventSink& out);
  /// One tick. `pressed` is the button now, `edges` how often it changed since the last tick. While `clutch` the hand
  /// moves and the hook or fragment that it holds stays; afterwards it follows from where it is, until it is let go.
  void tick(int64_t tick, const Pose& hand, bool pressed, int edges, const Snapshot& s, EventSink& out,
            bool clutch = false);

  ToolState state() const { return state_; }
  const SkinTouch& touched() const { return touch_; }  // the nearest skin at the last tick
  int64_t events() const { return seq_; }
  int64_t events_lost() const { return lost_; }
  /// Pressed with a tool, but not on what it acts on; a stitch that was let go in the air.
  int64_t missed_presses() const { return missed_; }

 private:
  enum class Doing { nothing, stroke, hold_hook, suture, carry };
  void press(int64_t tick, const Pose& pose, const Snapshot& s, EventSink& out);
  void release(int64_t tick, const Pose& pose, const Snapshot& s, EventSink& out);
  void stroke_on(int64_t tick, const Pose& pose, const Snapshot& s, EventSink& out);
  void cancel(int64_t tick, const Snapshot& s, EventSink& out);
  void add_blade_angle(const Pose& pose, const Vec3& travelled_mm);
  /// Of the touched place, at rest: out of the skin, or (right through) to the hand.
  Vec3 out_at_rest(const Snapshot& s) const;
  double blade_angle_deg() const;
  Vec3 tool_tip(const Vec3& hand_mm, bool clutch);
  void find_touch(int64_t tick, const Pose& pose, const Snapshot& s);
  void touch_where_rested(const Snapshot& s);
  /// The mean tip of a hand that rests, else the tip.
  Vec3 meant_tip() const;
  void name_place(const ControlSample& c, int64_t tick, const Snapshot& s, EventSink& out);
  void old_control(const ControlSample& c, int64_t tick, const Snapshot& s, EventSink& out);
  void press_hook(int64_t tick, const Pose& pose, const Snapshot& s, EventSink& out);
  void take_hook_out(int64_t tick, const Pose& pose, const Snapshot& s, EventSink& out);
  void press_scissors(int64_t tick, const Snapshot& s, EventSink& out);
  bool on_ground() const { return touch_.triangle >= 0 && touch_.distance_mm <= g_.reach_mm; }
  bool at_an_edge(const Snapshot& s) const;
  void bite(const Snapshot& s, EventSink& out, int64_t tick);
  bool take_other_bank(const Snapshot& s, const SkinTouch& first);
  void second_bite(int64_t tick, const Snapshot& s, EventSink& out);
  void show_bites(const Snapshot& s);
  /// A bite that was just let go may not have been seen yet.
  void let_thread_go(int64_t tick, const Snapshot& s, EventSink& out);
  void press_knot(int64_t tick, const Snapshot& s, EventSink& out);
  /// Of the touched place, in the tissue by a little where that is a cut face.
  void emit_bite(int kind, int64_t tick, const Snapshot& s, EventSink& out);
  void begin_stroke(int64_t tick, const Snapshot& s, EventSink& out);
  void emit_row(int64_t tick, const Snapshot& s, EventSink& out);
  ToolEvent event(int kind, int64_t tick, const Snapshot& s) const;
  void emit(ToolEvent e, EventSink& out);
  void miss(int kind, int64_t tick, EventSink& out);
  /// How far two touched places are apart at rest: in space, or on the chart.
  double apart(const SkinTouch& a, const SkinTouch& b) const;
  SurfaceIndex& index() {
    return acts_on_bone(tool_) ? bone_index_ : tool_ == Tool::suture_deep ? flesh_index_ : index_;
  }

  GestureSettings g_;
  SurfaceIndex index_{Ground::skin}, bone_index_{Ground::bone}, flesh_index_{Ground::flesh};
  SkinTouch touch_;
  Tool tool_ = Tool::none;
  double depth_mm_ = 4, angle_deg_ = 0, spacing_mm_ = 4;
  int32_t next_hook_ = 1, asked_hook_ = 0;  // asked_hook_: the number that the control gave, 0 = none
  Doing doing_ = Doing::nothing;
  bool pressed_ = false;
  Pose last_pose_;  // of the tool: where the hand is, but for what the clutch has left behind
  Vec3 shift_mm_ = Vec3::Zero();
  bool clutched_ = false, shifted_ = false;
  static constexpr size_t kRestTicks = 100;
  std::array<Vec3, kRestTicks> recent_tip_;  // a ring; recent_ ticks of it since tracking began
  size_t recent_ = 0;
  EdgeStroke edge_;                     // of a suture row
  std::array<SkinTouch, 2> row_edge_;   // the ends of its first edge,
  bool row_begun_ = false;              // while its second one is waited for
  std::array<SkinTouch, 2> bite_;       // of a stitch that is begun, the last two
  bool corner_waits_ = false;           // for its third bite
  int32_t knotted_ = 0;                 // the thread whose knot was made, until the patient shows it
  int64_t laid_down_ = -1;              // at this tick needle or knot went out of the hand, and a thread may hang on it
  SkinTouch last_stroke_;               // the stroke's newest point
  Vec3 last_drawn_tip_ = Vec3::Zero();  // where the hand was then
  int64_t lost_tick_ = -1;              // tracking was lost at this tick, during a gesture
  double angle_sum_deg_ = 0, angle_weight_mm_ = 0;
  RigidGrip grip_;
  int32_t bone_grabs_ = 0;
  OldControls old_;
  ToolState state_;
  int64_t seq_ = 0, lost_ = 0, missed_ = 0;
};

}  // namespace limberg
