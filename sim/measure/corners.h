#pragma once
// Corners of a triangle of the surface, mm: at rest, and as it lies now.
#include <array>
#include <span>

#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

inline std::array<Vec3, 3> corners_at_rest(const SurfaceView& v, size_t t) {
  return {v.X_mm[size_t(v.tri[t][0])], v.X_mm[size_t(v.tri[t][1])], v.X_mm[size_t(v.tri[t][2])]};
}
inline std::array<Vec3, 3> corners_now(const SurfaceView& v, std::span<const Vec3f> x_mm, size_t t) {
  return {x_mm[size_t(v.tri[t][0])].cast<double>(), x_mm[size_t(v.tri[t][1])].cast<double>(),
          x_mm[size_t(v.tri[t][2])].cast<double>()};
}

}  // namespace limberg
