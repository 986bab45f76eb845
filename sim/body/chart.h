#pragma once
// A plane on which places of the skin are named: mm along two directions at right angles.
#include "sim/geometry/vec.h"

namespace limberg {

/// A point of the skin as scripts name it: chart coordinates in mm, independent of any mesh.
/// Block: (x, y) of the flat skin, origin at its centre. Loaded surface: the tangent plane that the scene names.
using ChartPoint = Vec2;

struct Chart {
  Vec3 origin_mm = Vec3::Zero(), e1 = Vec3::UnitX(), e2 = Vec3::UnitY();  // orthonormal
  Vec3 normal() const { return e1.cross(e2); }
  ChartPoint to_chart(const Vec3& X_mm) const { return {(X_mm - origin_mm).dot(e1), (X_mm - origin_mm).dot(e2)}; }
  Vec3 to_space(const ChartPoint& p, double height_mm = 0) const {
    return origin_mm + p.x() * e1 + p.y() * e2 + height_mm * normal();
  }
};

}  // namespace limberg
