#pragma once
// What Bones keeps while a fragment is held.
#include <vector>

#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/rigid_world.h"

namespace limberg::bone {

/// Fragments that move as one are one part of the Bullet world; its frame is the rest of its first fragment.
struct Bones::Held {
  std::vector<std::vector<int32_t>> ids;
  std::vector<std::vector<Eigen::Isometry3d>> offset;
  size_t part = 0;  // the one in the hand
  std::unique_ptr<RigidWorld> world;
};

}  // namespace limberg::bone
