#pragma once
#include <cstdint>

#include "devices/tool_event.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// What a hand carries: a rigid motion about the hand's centre.
class RigidGrip {
 public:
  /// `scale`: of the way; turns are not scaled.
  void begin(const Vec3& centre_mm, const Eigen::Quaterniond& orientation, double scale);
  /// The motion of the object since begin(), a map of places to places. Nothing moves while `clutch`.
  const Eigen::Isometry3d& follow(const Vec3& centre_mm, const Eigen::Quaterniond& orientation, bool clutch);
  const Eigen::Isometry3d& motion() const { return motion_; }

 private:
  Eigen::Isometry3d motion_ = Eigen::Isometry3d::Identity(), base_ = Eigen::Isometry3d::Identity();
  Vec3 from_ = Vec3::Zero(), held_at_ = Vec3::Zero();  // the hand's centre, the virtual one, when motion_ was base_
  Vec3 now_at_ = Vec3::Zero();
  Eigen::Quaterniond turned_from_ = Eigen::Quaterniond::Identity();
  double scale_ = 1;
  bool clutched_ = false;
};

/// The map that a hand has carried something by, in the words of the channels; `holds`: see Carried.
Carried carried(const Eigen::Isometry3d& motion, int32_t holds);
Eigen::Isometry3d motion_of(const Carried& carried);

}  // namespace limberg
