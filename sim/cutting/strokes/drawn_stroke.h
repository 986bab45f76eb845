#pragma once
// An incision that opens while it is drawn, by the rules of one that is made at once (stroke_plan.h):
//
//   DrawnStroke stroke(4, 90);
//   stroke.draw(context, points);                  // as often as the hand has moved on
//   for (;;) {                                     // what can be cut by now, cut by cut
//     BladeResult b = stroke.next(context, last);
//     if (!b.blade) break;                         // with a reason: refused
//     ... stroke.was_cut(context, result), was_nothing(context), or was_refused()
//   }
//
//  * Ways along walls that were there before it deepen them, as far as
//    the hand has come. What of them cannot be deepened (a leaning blade
//    at a sharp corner) is halved until the rest goes on without it.
//  * Free ways are blades handed out in pieces (drawn_incision.h)
//    that begin and end on what is there, go on from the open
//    ends of walls, and cross what the stroke itself has cut.
//  * An end that comes back to the stroke's own beginning shares its edge. A beginning that the stroke later passes by
//    within kSnap is led through that wall; nearer than 0.25 mm, the stroke is led across its beginning.
//
// What is known later than it is cut stays: of an end drawn past the
// stroke's own beginning, at once both stubs go, here only the later one.
#include <memory>

#include "sim/cutting/strokes/drawn_incision.h"
#include "sim/cutting/strokes/stroke_runs.h"

namespace limberg {

class DrawnStroke {
 public:
  /// angle_deg as for build_incision.
  DrawnStroke(double depth_mm, double angle_deg)
      : depth_(depth_mm), angle_deg_(angle_deg), free_(depth_mm, angle_deg) {}

  /// More of the path. Not empty: why it cannot be taken; nothing was.
  std::string draw(const BladeContext& context, std::span<const ChartPoint> points);

  /// The next blade. No blade and no reason: nothing new can be cut yet, or with `last` nothing is left.
  BladeResult next(const BladeContext& context, bool last);
  void was_cut(const CutResult& result);
  void was_nothing(const BladeContext& context);
  bool was_refused();  // true: there is another way, ask for the next one again

  double length_mm() const { return path_length(path_); }

 private:
  enum Kind : uint8_t { none, along, free_way, start_wall };
  /// How far the present way goes: settled up to `to`, and whether it ends there.
  struct Stretch {
    double to = 0;
    bool ends = false;
  };
  Stretch stretch(const BladeContext& context, const WallMap& walls, bool last) const;
  BladeResult deepen(const BladeContext& context, const Stretch& s);
  bool narrow();
  std::optional<Blade> lead_start_through(const BladeContext& context);
  void begin_way(const BladeContext& context, double from, bool is_along);

  double depth_, angle_deg_;
  std::vector<Vec2> path_;                  // points at least kKnot apart, without curls
  Vec2 end_ = Vec2::Zero();                 // the last point drawn, whatever its distance
  int32_t operations_before_ = -1;          // of the arrangement: walls that were there before the stroke
  std::shared_ptr<const WallMap> earlier_;  // those walls, as they were when it began; their fronts may be others now
  double level_ = 0;                        // of the foot of what it deepens
  double from_ = 0;                         // of the present way, along the path
  bool along_ = false;
  double offered_to_ = 0, nothing_to_ = -1;      // along a wall: how far; up to where nothing was left to cut
  double along_from_ = 0, along_limit_ = 1e300;  // what is tried of the way along a wall: less after a refusal
  DrawnIncision free_;
  Vec2 start_ = Vec2::Zero();  // of the free way
  bool start_is_led_ = false, over_ = false;
  Kind offered_ = none;
};

}  // namespace limberg
