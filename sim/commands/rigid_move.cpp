#include <numbers>

#include "sim/commands/head_command.h"
#include "sim/geometry/rotation.h"

namespace limberg {

namespace {
constexpr double kDegree = std::numbers::pi / 180;
}  // namespace

Eigen::Isometry3d isometry(const RigidMove& m, const Vec3& centre_mm) {
  const Vec3 about = m.about_mm.value_or(centre_mm);
  const double angle = m.rotation_deg.norm() * kDegree;
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  if (angle > 0) turn.linear() = rotation(angle, m.rotation_deg.normalized());
  turn.translation() = about - turn.linear() * about + m.translation_mm;
  return turn;
}

RigidMove as_move(const Eigen::Isometry3d& map) {
  const AxisAngle turn = axis_angle(map.linear());
  RigidMove m;
  m.translation_mm = map.translation();
  m.rotation_deg = turn.axis * (turn.angle / kDegree);
  m.about_mm = Vec3::Zero();
  return m;
}

}  // namespace limberg
