#pragma once
// One stroke of the scalpel as the cuts that it is made of, in order.
//
//  * What runs along an earlier wall (within kSnap on the skin, 15 degrees, blades alike) deepens it from its front, or
//    does nothing where that is deep enough.
//  * What crosses itself is divided between the passages: the second part begins where the first ends, shares its end
//    edge, and crosses it as it would any earlier cut.
//  * What leans into a sharp corner is made in legs (leg_end), each of the depth and the lean asked to its end.
//  * What still would run through itself at depth, leaning into a bend, is divided at its corners; what still would is
//    cut shallower, and deepened where that goes.
//  * An end that comes back to the stroke's own beginning closes the loop; one that comes near the stroke's own middle
//    ends on it.
// All other strokes are one cut. Each cut is built on what the ones before it have left.
#include <functional>

#include "sim/cutting/strokes/blade_build.h"

namespace limberg {

struct StrokePiece {
  std::vector<Vec2> path;
  bool along = false;   // deepens what it runs along
  bool on_leg = false;  // begins on the piece before
};

struct StrokePlan {
  std::vector<StrokePiece> piece;  // empty: see reason
  std::string reason;
  double depth_mm = 0, angle_deg = 90;
};

/// `spline`: the path's points are control points of a curve (spline_through).
StrokePlan plan_stroke(const BladeContext& context, std::span<const ChartPoint> path, double depth_mm, double angle_deg,
                       bool spline = false);

/// Makes the cuts of a stroke, all or none. `cut` makes one, `take_back` takes the last that was made back. The status
/// is done if any cut was made; wall_faces and patches are sums, the rest is the last cut's.
CutResult carry_out(const StrokePlan& plan, const BladeContext& context,
                    const std::function<CutResult(const Blade&)>& cut, const std::function<void()>& take_back);

/// Both, on an arrangement (context.arrangement is set to it). `cuts` gets how many operations it took: undo that many.
CutResult incise(Arrangement& arrangement, BladeContext context, std::span<const ChartPoint> path, double depth_mm,
                 double angle_deg, uint64_t seed, bool spline = false, int* cuts = nullptr);

}  // namespace limberg
