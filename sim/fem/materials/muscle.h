#pragma once
// What a muscle adds when it is active: a pull along its fibres, greatest at the length at which it rests.
//
//   dW/dl = activation T (1 - ((l - 1) / w)^2), none beyond,   l = |F a|
//
// T is the greatest tension that it can hold without moving, per area at rest; w = .56, the half width of the parabola
// of tension over length, is that of whole muscles in van Soest and Bobbert 1993. It pulls at F = I too: an active
// muscle is not at rest there.
#include "sim/fem/materials/law.h"

namespace limberg {

/// `fibre`: the way that it runs at rest, in the frame of the law. Throws InputError on a tension below 0, an
/// activation outside of 0 to 1 or a fibre of no length.
LawPtr active_fibres(double tension_kPa, double activation, const Vec3& fibre);

}  // namespace limberg
