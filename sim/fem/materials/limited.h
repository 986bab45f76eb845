#pragma once
// Limits of stretch: what a tissue adds once a principal stretch leaves a range, and nothing within it.
//
//   W = k/2 sum_i ((s_i - most)+^2 + (least - s_i)+^2)
//
// A stiff end, as strain limits of other simulators are, but an energy: a solver may pass it and comes back. k in kPa
// is the slope of the nominal stress beyond. It is smooth but for its second derivative at the limits, and defined for
// every stretch, inverted ones too.
#include "sim/fem/materials/law.h"

namespace limberg {

/// Throws InputError unless 0 < least < 1 < most and k_kPa > 0: at rest nothing is beyond.
LawPtr stretch_limits(double least, double most, double k_kPa);

}  // namespace limberg
