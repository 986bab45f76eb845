#pragma once
// Whether a cut right through (blade_build.h) comes to the body's free margin, for whoever draws one by hand.
#include "sim/geometry/vec.h"

namespace limberg {

class Skin;

/// Whether the part of the body that a blade at X goes through along -out ends within reach_mm on the way `way`; both
/// unit, across each other, at rest. False where the blade does not come out on another side.
bool margin_beyond(const Skin& skin, const Vec3& X_mm, const Vec3& out, const Vec3& way, double reach_mm);

}  // namespace limberg
