#pragma once
// Colours of the anatomical head by place: skin, vermilion, brows, shaven hair, globe with iris and pupil; teeth.
#include <array>

#include "sim/geometry/vec.h"

namespace limberg::anatomical {

/// sRGB, 0 to 1, of a place on the skin.
Vec3 skin_colour(const Vec3& p_mm);

/// Three bytes sRGB, and how much of it is seen beside the material's own look.
std::array<uint8_t, 4> colour_on_face(const Vec3& p_mm);
/// Enamel; all else has the look of bone (0 is seen).
std::array<uint8_t, 4> colour_on_bone(const Vec3& p_mm);

}  // namespace limberg::anatomical
