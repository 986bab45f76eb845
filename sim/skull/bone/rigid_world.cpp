#include "sim/skull/bone/rigid_world.h"

#include <stdexcept>

#include "sim/base/part.h"

namespace limberg::bone {

namespace {

using MakeRigidWorld = RigidWorld* (*)(const std::vector<RigidPart>& parts, const std::vector<size_t>& held);

LoadedPart bullet() { return load_part("bullet", "limberg_rigid_world", "Bullet (Debian: libbullet-dev)"); }

}  // namespace

std::string why_no_physics() {
  const LoadedPart part = bullet();
  return part.entry ? "" : "bone cannot be held without Bullet: " + part.why;
}

std::unique_ptr<RigidWorld> make_rigid_world(const std::vector<RigidPart>& parts, const std::vector<size_t>& held) {
  const LoadedPart part = bullet();
  if (!part.entry) throw std::runtime_error(why_no_physics());
  return std::unique_ptr<RigidWorld>(reinterpret_cast<MakeRigidWorld>(part.entry)(parts, held));
}

}  // namespace limberg::bone
