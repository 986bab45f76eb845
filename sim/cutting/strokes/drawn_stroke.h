#pragma once
// One stroke of the scalpel, whole or still being drawn, by one set of rules:
//
//   DrawnStroke stroke(4, 90);
//   stroke.draw(context, points);          // as often as the hand has moved on
//   stroke.cut(context, false, make_cut);  // what can be cut by now; make_cut makes one
//   stroke.cut(context, true, make_cut);   // the rest, with its end
//
// A whole stroke (cut_whole) is a drawn one whose first points are all there are.
//
//  * Ways along walls that were there before the stroke deepen them, as far as the hand has come. What of them cannot
//    be deepened (a leaning blade at a sharp corner) is halved until the rest goes on without it. The
//    same stroke once more may then deepen that.
//  * Free ways are blades handed out in pieces (drawn_incision.h) that begin and end on what is there, go on from the
//    open ends of walls, and cross what the stroke itself has cut.
//  * An end that comes back to the stroke's own beginning shares its edge. A beginning that the stroke later passes by
//    within kSnap is led through that wall; nearer than 0.25 mm, the stroke is led across its beginning.
//
// What is known later than it is cut stays: of an end drawn across the stroke's own beginning, a whole stroke leaves
// off both stubs, a drawn one only the later.
#include <functional>
#include <memory>

#include "sim/cutting/strokes/drawn_incision.h"
#include "sim/cutting/strokes/stroke_runs.h"

namespace limberg {

/// Makes one cut. context.arrangement is what it changes.
using MakeCut = std::function<CutResult(const Blade&)>;

class DrawnStroke {
 public:
  /// depth_mm is the depth of tissue at rest along the skin's normal. angle_deg is measured between blade and skin, as
  /// they lie now, in the plane across the path; below 90 the blade leans so that its edge lies to the right of the
  /// path (seen from outside, walking along it).
  DrawnStroke(double depth_mm, double angle_deg)
      : depth_(depth_mm), angle_deg_(angle_deg), free_(depth_mm, angle_deg) {}

  /// More of the path. Not empty: why it cannot be taken; nothing was.
  std::string draw(const BladeContext& context, std::span<const ChartPoint> points);

  /// Cuts what can be cut by now; with `last` all that is left. The status is done if anything was cut, nothing_to_cut
  /// if nothing was (then the reason says so with `last`), refused if a blade was: what was cut before it in this call
  /// is for the caller to take back. wall_faces, patches and patches_kept are sums, the rest is the last cut's.
  CutResult cut(const BladeContext& context, bool last, const MakeCut& make_cut);

  double length_mm() const { return path_length(path_); }

 private:
  /// The next blade. No blade and no reason: nothing new can be cut yet, or with `last` nothing is left.
  BladeResult next(const BladeContext& context, bool last);
  void was_cut(const CutResult& result);
  void was_nothing(const BladeContext& context);
  bool was_refused();  // true: there is another way, ask for the next one again

  enum Kind : uint8_t { none, along, free_way, start_wall };
  /// How far the present way goes: settled up to `to`, and whether it ends there.
  struct Stretch {
    double to = 0;
    bool ends = false;
  };
  void settle_end(const BladeContext& context);
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
  bool start_is_led_ = false, over_ = false, any_cut_ = false, any_free_ = false;
  Kind offered_ = none;
};

/// A whole stroke: cleaned of tremor, drawn and cut at once. `spline`: the path's points are control points of a curve
/// (spline_through). Else as DrawnStroke::cut.
CutResult cut_whole(const BladeContext& context, std::span<const ChartPoint> path, double depth_mm, double angle_deg,
                    bool spline, const MakeCut& make_cut);

/// The same on an arrangement (context.arrangement is set to it), all or nothing. Cut number n of the stroke is made
/// with seed + n. `cuts` gets how many operations it took: undo that many.
CutResult incise(Arrangement& arrangement, BladeContext context, std::span<const ChartPoint> path, double depth_mm,
                 double angle_deg, uint64_t seed, bool spline = false, int* cuts = nullptr);

}  // namespace limberg
