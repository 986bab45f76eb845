#pragma once
// A blade held at an angle to skin that is stretched, sheared and turned: what direction is that at rest?
#include "sim/geometry/vec.h"

namespace limberg {

/// The blade's way into the tissue at rest, aside from the skin's normal, in mm per mm of depth: a vector in the rest
/// skin's plane. In the deformed state the blade makes the angle with tangent `lean` (cotangent of the angle between
/// blade and skin; positive: its edge to the right of the path) in the plane across the path.
///
///   t' = F t,  n' ~ F^-T n,  d' = -n' + lean (t' x n') / |t' x n'|,  D ~ F^-1 d', scaled to D . n = -1
///
/// Tissue that is nearly as at rest (|F - 1| below kAsAtRest) counts as at rest. Where F is flattened beyond
/// kConditionLimit its smaller singular values are raised to that share of the largest; where it is inverted the
/// rotation of its polar part stands for it. The result is at most kMostAside long.
///   normal, along: unit, at rest, perpendicular.
Vec3 aside_at_rest(const Mat3& F, const Vec3& normal, const Vec3& along, double lean);

inline constexpr double kAsAtRest = 0.01;  // half a degree, less than a hand can hold
inline constexpr double kConditionLimit = 4;
inline constexpr double kMostAside = 2.75;  // 20 degrees between blade and skin, the least that can be asked for

}  // namespace limberg
