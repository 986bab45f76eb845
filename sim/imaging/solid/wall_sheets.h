#pragma once
// How thick a wall of bone is that the scanner has blurred, and where its middle lies.
//
// Across a thin wall the picture shows the wall's density times its thickness, spread out by the scanner. The spread
// keeps the integral: with C the density of cortical bone and B that of what lies beside the wall (on either side, and
// straight in between),
//
//   thickness = integral of (I - B) / (C - B) across the wall,   middle = the centre of mass of I - B
//
// whatever the spread (Treece, Gee, Mayhew, Poole 2010 fit this model to cortices, with C from where bone is thick).
#include <vector>

#include "sim/imaging/io/volume.h"

namespace limberg::imaging {

struct WallSheet {
  Vec3 middle_mm = Vec3::Zero(), normal = Vec3::UnitZ();
  double thickness_mm = 0;
  double contrast = 0;  // of the crest over the denser of what lies beside it
};

/// The wall that passes by x with that normal (unit); `reach_mm`: how far to either side it and its blur go. Thickness
/// 0: there is none, or what lies beside it is as dense as `cortical`.
WallSheet wall_sheet(const VolumeSampler& volume, const Vec3& x_mm, const Vec3& normal, double reach_mm,
                     double cortical);

}  // namespace limberg::imaging
