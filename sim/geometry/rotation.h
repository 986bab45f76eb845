#pragma once
// Rotations about an axis (Rodrigues), with functions that give the same bits everywhere: Eigen::AngleAxis asks the C
// library.
#include <Eigen/Geometry>
#include <algorithm>

#include "sim/base/elementary.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// About a unit axis, in radians.
inline Mat3 rotation(double angle, const Vec3& axis) {
  const double s = elementary::sin(angle), c = elementary::cos(angle);
  Mat3 K;
  K << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return c * Mat3::Identity() + s * K + (1 - c) * axis * axis.transpose();
}

struct AxisAngle {
  Vec3 axis = Vec3::UnitX();
  double angle = 0;  // radians, 0 .. pi
};
inline AxisAngle axis_angle(const Mat3& R) {
  const Eigen::Quaterniond q(R);
  const double n = q.vec().norm();
  if (n == 0) return {};
  return {(q.w() < 0 ? -1 / n : 1 / n) * q.vec(), 2 * elementary::atan2(n, std::abs(q.w()))};
}

/// The same as rotation(), as a quaternion.
inline Eigen::Quaterniond turn_about(double angle, const Vec3& axis) {
  const Vec3 v = elementary::sin(angle / 2) * axis;
  return {elementary::cos(angle / 2), v.x(), v.y(), v.z()};
}

/// From a (part 0) to b (part 1) along the shorter great circle.
inline Eigen::Quaterniond between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double part) {
  const AxisAngle way = axis_angle((b * a.conjugate()).toRotationMatrix());
  return turn_about(part * way.angle, way.axis) * a;
}

/// Azimuth about z, elevation about the new y, roll about the new x, in radians: R = Rz Ry Rx.
inline Vec3 azimuth_elevation_roll(const Mat3& R) {
  return {elementary::atan2(R(1, 0), R(0, 0)), elementary::asin(std::clamp(-R(2, 0), -1., 1.)),
          elementary::atan2(R(2, 1), R(2, 2))};
}

}  // namespace limberg
