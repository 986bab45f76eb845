#include "devices/rigid_grip.h"

namespace limberg {

void RigidGrip::begin(const Vec3& centre_mm, const Eigen::Quaterniond& orientation, double scale) {
  motion_ = base_ = Eigen::Isometry3d::Identity();
  from_ = held_at_ = now_at_ = centre_mm;
  turned_from_ = orientation;
  scale_ = scale;
  clutched_ = false;
}

const Eigen::Isometry3d& RigidGrip::follow(const Vec3& centre_mm, const Eigen::Quaterniond& orientation, bool clutch) {
  if (clutch || clutched_) {
    // From here on it is as if it had been grabbed here, in the place where it is.
    base_ = motion_;
    from_ = centre_mm, held_at_ = now_at_, turned_from_ = orientation;
    clutched_ = clutch;
    return motion_;
  }
  // A place x of base goes to c + R (x - c0), where the virtual centre goes from c0 to c = c0 + scale (centre - from).
  now_at_ = held_at_ + scale_ * (centre_mm - from_);
  const Eigen::Isometry3d turn = Eigen::Translation3d(now_at_) * (orientation * turned_from_.conjugate()).normalized() *
                                 Eigen::Translation3d(-held_at_);
  return motion_ = turn * base_;
}

Carried carried(const Eigen::Isometry3d& motion, int32_t holds) {
  Carried c;
  c.holds = holds;
  const Eigen::Quaterniond q(motion.linear());
  c.quat[0] = q.w(), c.quat[1] = q.x(), c.quat[2] = q.y(), c.quat[3] = q.z();
  for (int i = 0; i < 3; ++i) c.shift_mm[i] = motion.translation()[i];
  return c;
}

Eigen::Isometry3d motion_of(const Carried& c) {
  Eigen::Isometry3d m = Eigen::Isometry3d::Identity();
  m.linear() = Eigen::Quaterniond(c.quat[0], c.quat[1], c.quat[2], c.quat[3]).normalized().toRotationMatrix();
  m.translation() = Vec3(c.shift_mm[0], c.shift_mm[1], c.shift_mm[2]);
  return m;
}

}  // namespace limberg
