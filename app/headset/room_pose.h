#pragma once
// A place in the room of a headset. The room is in metres with y upwards, as OpenXR has it.
#include "sim/geometry/vec.h"

namespace limberg {

struct RoomPose {
  Vec3 at_m = Vec3::Zero();
  Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();  // looks along its -z, +y upwards
};

}  // namespace limberg
