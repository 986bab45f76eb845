#pragma once
// Drawn lines in the chart plane: cleaned of noise and pauses, checked, resampled.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/geometry/polyline.h"
#include "sim/geometry/spline.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// A place of a path is far from another when the way between is longer: passages nearer than this are one.
inline constexpr double kFarAlong = 3.0;

/// Is every number finite?
bool all_finite(std::span<const Vec2> path);

/// Drops points nearer than `distance` to the one kept before (the ends stay): what remains of a resting hand's knots.
std::vector<Vec2> drop_close(std::span<const Vec2> path, double distance);

/// The direction in which a path arrives at its first point, seen over its first `over` mm.
Vec2 heading_at_start(std::span<const Vec2> path, double over);

/// Where a polyline (or, when closed, a polygon) first meets itself other than at joints; nothing when it does not.
std::optional<Vec2> meets_itself(std::span<const Vec2> path, bool closed);

/// Into how many equal parts of at most `spacing` a length is divided.
int equal_parts(double length, double spacing);

/// Divides every segment into equal parts of at most `spacing`; a closed path gets no repeated end.
std::vector<Vec2> resample(std::span<const Vec2> path, double spacing, bool closed);

/// Where a polyline crosses itself: arc lengths of the two
/// passages, by the later one. Neighbouring segments do not count.
struct SelfCrossing {
  double first = 0, second = 0;
};
std::vector<SelfCrossing> self_crossings(std::span<const Vec2> path);

/// Without the small loops of an unquiet hand.
std::vector<Vec2> without_curls(std::vector<Vec2> path);

/// Where a path passes its own beginning within 0.25 mm, it is led across its first part, 0.5 mm from there: blades a
/// few micrometres apart would part the tissue at some depths and not at others.
std::vector<Vec2> clear_of_start(std::vector<Vec2> path);

/// The part of a polyline between two arc lengths.
std::vector<Vec2> part_of(std::span<const Vec2> path, double from, double to);

}  // namespace limberg
