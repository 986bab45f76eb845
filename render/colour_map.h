#pragma once
// Colour maps. Viridis for magnitudes: lightness grows evenly from one end to the other, so the map can be read in grey
// and by colour-blind eyes. Blue to red over a light grey for signed values: the middle is zero, both ends are equally
// dark, and blue against red is told apart by the common kinds of colour blindness.
#include "render/image.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// t in [0, 1], clamped; NaN gives the low end.
Rgb8 viridis(double t);

/// -1 dark blue, 0 light grey, 1 dark red; clamped; NaN gives the middle.
Rgb8 diverging(double t);

enum class ColourScale : uint8_t { magnitude, signed_value };
/// t in [0, 1] over the scale's range: viridis, or diverging with its middle at 0.5.
Rgb8 colour_of(ColourScale scale, double t);

/// Of sRGB, 0 to 1, in linear light (IEC 61966-2-1).
double linear_light(double srgb);
Vec3f linear_light(const Vec3f& srgb);

/// CIE lightness L* (0..100) of an sRGB colour, D65.
double lightness(Rgb8 c);

}  // namespace limberg
