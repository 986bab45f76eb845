#pragma once
// Colour maps for magnitudes. Viridis: lightness grows evenly from one end to the other, so the map can be read in grey
// and by colour-blind eyes.
#include "render/image.h"

namespace limberg {

/// t in [0, 1], clamped; NaN gives the low end.
Rgb8 viridis(double t);

/// CIE lightness L* (0..100) of an sRGB colour, D65.
double lightness(Rgb8 c);

}  // namespace limberg
