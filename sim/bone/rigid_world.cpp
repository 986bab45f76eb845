#include "sim/bone/rigid_world.h"
namespace limberg::bone {
struct RigidWorld::Inside {};
RigidWorld::~RigidWorld() = default;
}
