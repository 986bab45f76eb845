#pragma once
// Three lengths between the ends of a Z-plasty's central limb, each over their distance at rest.
#include <optional>
#include <span>

#include "sim/measure/skin_shape.h"

namespace limberg {

/// Roggendorf 1982 keeps two gains apart: what is gained over
/// the surface, ears included, and what is gained in the plane.
struct Elongations {
  double direct = 1;       // straight through space
  double planimetric = 1;  // the same, laid into the original skin's tangent plane half way between the ends
  // over the skin: the profile in the upright plane through both ends; where there is no skin, straight
  double stereometric = 1;
};
std::optional<Elongations> elongations(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
                                       const CentralLimb& limb);

}  // namespace limberg
