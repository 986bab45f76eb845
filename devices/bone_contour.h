#pragma once
// From the places that a hand drew on bone to the closed line of an osteotomy.
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct BoneContourSettings {
  double step_mm = 2;      // between the places of the result
  double smooth_mm = 2.5;  // half width of the mean that takes the tremor out, along the line
  double least_mm = 15;    // a shorter line means nothing
};

/// `drawn`: places on the bone at rest, in order. A hand that comes back to where it began ends the line there, what it
/// drew beyond is left out; else the ends are joined. Smoothed as a closed line and evenly spaced. Empty: too short.
std::vector<Vec3> bone_contour(const std::vector<Vec3>& drawn, const BoneContourSettings& settings = {});

}  // namespace limberg
