#pragma once
// A contour as it was drawn or picked, laid on the surface of a bone, and the ribbon that it sweeps.
#include <string>
#include <vector>

#include "sim/skull/bone/surface.h"

namespace limberg::bone {

struct DrawnPath {
  std::string reason;            // why it is no closed contour on the bone; the rest is empty then
  std::vector<Vec3> x_mm;        // on the surface, closed, about kSpacing_mm apart
  std::vector<Vec3> inward;      // unit, smoothed along the path: where the blade goes
  std::vector<double> depth_mm;  // of bone along it; infinite where nothing is met
  static constexpr double kSpacing_mm = 1;
};

/// Refused: fewer than three places, not finite, more than 5000, further than 10 mm from the bone, a drawn path whose
/// ends lie apart, a way between picks that the surface does not allow, a path that crosses itself.
DrawnPath lay_path(const BoneSurface& bone, const std::vector<Vec3>& path_mm);

/// True where the bone under the path is solid: for more than half of it the blade would need more than deepest_mm, or
/// comes out again beside the path itself, which then runs around the bone.
bool is_solid(const DrawnPath& path, double deepest_mm);

struct Ribbon {
  std::vector<Vec3> X_mm;
  std::vector<Tri> tri;  // normals to the left of the path, seen from outside
};
/// From above_mm over the surface down to depth_mm[i] under it.
Ribbon sweep(const DrawnPath& path, double above_mm, const std::vector<double>& depth_mm);
/// The same with the blade tilted: along the path's own directions over the surface, along `inward` under it.
Ribbon sweep_tilted(const DrawnPath& path, const std::vector<Vec3>& inward, double above_mm,
                    const std::vector<double>& depth_mm);

}  // namespace limberg::bone
