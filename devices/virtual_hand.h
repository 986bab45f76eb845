#pragma once
// The hand of the glove in the scene: it points, grabs, carries and lets go.
//
//   pointing   the closest place of the skin that the line of the forefinger
//              meets; where it meets none, the place least beside it within
//              a cone. A hand that closes bends its forefinger: once it
//              closes faster than OpeningRate::kClosing_mm_s, or is less than 60 % open,
//              the place that was pointed at last is kept.
//   grab       what is pointed at is held from the tick on which the hand
//              closes, where it is: nothing jumps. Skin is held by a hook
//              that follows the hand (ToolEvent::hook_set, hand 1), bone is
//              carried as it is (ToolEvent::bone_grab). Where both lie in its
//              way, bone is meant while the other hand has a tool for bone.
//   carry      it turns with the hand about the hand's centre, and moves with it times the motion scale
//   clutch     while it is down the hand moves and what it holds does not
//   release    when the hand opens. A hand out of sight keeps what it holds.
//
// A tick allocates nothing; the search for what is pointed at is spread over kSlices ticks.
#include <cstdint>

#include "calibration/calibration.h"
#include "devices/glove.h"
#include "devices/rigid_grip.h"
#include "devices/tool_event.h"
#include "sim/patient/snapshot.h"

namespace limberg {

struct PointedPlace {
  int32_t triangle = -1;  // of the view; -1: nothing
  std::array<double, 3> bary{1, 0, 0};
  Vec3 x_mm = Vec3::Zero(), X_mm = Vec3::Zero();  // deformed, at rest
  double along_mm = 0;                            // from the finger tip
  double beside_rad = 0;  // between the forefinger's direction and the place; 0: the line meets it
};

/// The place of the skin (or of the bone) in a direction. Call step()
/// once per tick; place() is that of the last sweep that was finished.
class PointingSearch {
 public:
  static constexpr int kSlices = 32;
  double cone_rad = 0.17, reach_mm = 500;
  Ground ground = Ground::skin;  // what can be pointed at
  void step(const Snapshot& s, const Vec3& origin_mm, const Vec3& direction);
  const PointedPlace& place() const { return found_; }
  /// All at once, for whoever is in no hurry.
  PointedPlace find(const Snapshot& s, const Vec3& origin_mm, const Vec3& direction) const;

 private:
  void slice(const Snapshot& s, size_t from, size_t to, const Vec3& origin, const Vec3& direction,
             PointedPlace& best) const;
  static void finish(const Snapshot& s, PointedPlace& p);
  uint64_t version_ = 0;
  size_t next_ = 0;
  Vec3 origin_ = Vec3::Zero(), direction_ = Vec3::UnitX();
  PointedPlace best_, found_;
};

/// Where the glove's hand is, and what it holds: beside ToolState on its way to the solver.
struct SecondHand {
  int32_t valid = 0, closed = 0, held_hook = 0;
  double hook_mm[3]{};  // where the hook that it holds is pulled to
  double centre_mm[3]{};
  Carried carried;  // the fragment that it holds
  // For pictures:
  double forefinger_mm[3]{}, thumb_mm[3]{};  // the finger tips
  double pointing[3]{1, 0, 0};               // the forefinger's direction, unit
  /// Unit, across the forefinger towards the thumb, as the open hand had it, turned as the sensors turned since; zero
  /// before the hand was open.
  double thumbwards[3]{};
  int32_t points = 0;      // 1: at pointed_mm, the place that would be selected; of a hand that holds something,
  double pointed_mm[3]{};  // where it holds it
};

class VirtualHand {
 public:
  static constexpr int32_t kFirstHook = 1001;  // times its number: hands' hooks do not meet
  static constexpr double kFrozenBelow = 0.6;  // share of the opening below which the pointed place is kept
  /// `number`: of the hand in its events, 1 or 2.
  explicit VirtualHand(const GloveParameters& glove, int32_t number = 1)
      : glove_(glove), number_(number), next_hook_(kFirstHook * number) {}

  /// `ground`: what it points at; bone where there is nothing else.
  void tick(int64_t tick, const HandPose& hand, bool clutch, const Snapshot& s, EventSink& out,
            Ground ground = Ground::skin);
  /// Instead of tick() while the hand pushes a cursor: nothing is pointed at or grabbed, and a hand that is closed when
  /// it points again has to open first.
  void show_at_cursor(const HandPose& hand, bool there, const Vec3& cursor_mm);
  const PointedPlace& pointed() const { return pointed_; }
  const RigidGrip& grip() const { return grip_; }
  const SecondHand& state() const { return state_; }
  int64_t grabs() const { return grabs_; }
  int64_t empty_grabs() const { return empty_; }  // closed, but nothing was pointed at
  int64_t events_lost() const { return lost_; }

 private:
  void emit(ToolEvent e, EventSink& out);
  void note_fingers(const HandPose& hand);
  GloveParameters glove_;
  int32_t number_ = 1;
  PointingSearch search_;
  PointedPlace pointed_;
  RigidGrip grip_;
  SecondHand state_;
  Vec3 held_mm_ = Vec3::Zero();
  Vec3 thumbwards_ = Vec3::Zero();  // in the frame of the hand's orientation
  bool was_closed_ = false;
  OpeningRate opening_;
  int32_t next_hook_, bone_grabs_ = 0;
  int64_t grabs_ = 0, empty_ = 0, lost_ = 0;
};

}  // namespace limberg
