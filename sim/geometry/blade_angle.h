#pragma once
// How a blade may stand to the skin, in the plane across its path: scripts, strokes and blades keep to the same.

#include <cmath>
#include <numbers>

#include "sim/base/elementary.h"

namespace limberg {

/// A flatter blade does not come out of the tissue where it should.
inline constexpr double kLeastBlade_deg = 20, kMostBlade_deg = 160;
inline constexpr const char* kBladeAngles = "the angle between blade and skin must be 20 to 160 degrees";

inline constexpr bool blade_can_lean(double angle_deg) {
  return angle_deg >= kLeastBlade_deg && angle_deg <= kMostBlade_deg;
}

/// The way aside per way down, to the right of the path: cotangent of the angle between blade and skin.
inline double blade_lean(double angle_deg) {
  const double angle = angle_deg * std::numbers::pi / 180;
  return elementary::cos(angle) / elementary::sin(angle);
}

}  // namespace limberg
