#pragma once
// What Bones keeps while a fragment is held.
#include <vector>

#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/rigid_world.h"

namespace limberg::bone {

/// Fragments that move as one are one part of the Bullet world; its frame is the rest of its first fragment.
struct Bones::Held {
  struct InHand {
    int32_t id = -1;
    size_t part = 0;
    Eigen::Isometry3d wanted;  // of the part
  };
  std::vector<std::vector<int32_t>> ids;
  std::vector<std::vector<Eigen::Isometry3d>> offset;
  std::vector<InHand> in_hand;  // in the order of their grabs
  std::unique_ptr<RigidWorld> world;
  /// As it was before the first grab; of what was let go meanwhile, as it was left. What is in a hand has not moved
  /// yet, as far as undo and redo are concerned.
  BonesState before;
};

}  // namespace limberg::bone
