#pragma once
// Curves through control points, as polylines.
#include <span>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// The centripetal Catmull-Rom curve through control points (Yuksel, Schaefer and Keyser
/// 2011: no cusps, no loops of its own), sampled at most `spacing` apart; control points
/// stay points. Where the control polygon turns by more than 60 degrees the curve keeps the
/// corner. Straight runs stay straight. A path whose last point equals its first is closed.
std::vector<Vec2> spline_through(std::span<const Vec2> control, double spacing);

}  // namespace limberg
