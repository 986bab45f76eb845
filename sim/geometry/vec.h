#pragma once
// Small vector types shared by every part of the simulator. Lengths are mm unless a name says otherwise.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <compare>
#include <cstdint>
#include <numbers>

namespace limberg {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;
using Mat3 = Eigen::Matrix3d;

inline constexpr double kDeg = 180 / std::numbers::pi;  // degrees of a radian

/// The third component of a x b: twice the signed area of the triangle 0, a, b.
inline double cross2(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }
/// The cofactor matrix det(F) F^-T, also of a singular F.
inline Mat3 cofactor(const Mat3& F) {
  Mat3 c;
  c << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return c;
}

/// A point of the integer rest grid (see rest_grid.h), or an index triple of a lattice.
struct Int3 {
  int32_t x = 0, y = 0, z = 0;
  auto operator<=>(const Int3&) const = default;
  int32_t operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

/// Three vertex indices, counter-clockwise seen from outside the material.
using Tri = std::array<int32_t, 3>;

}  // namespace limberg
