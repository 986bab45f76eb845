// Fragments held by the hand, and the gaps between them.
#include <algorithm>
#include <cmath>

#include "sim/bone/bones.h"
#include "sim/bone/rigid_world.h"
#include "sim/bone/surface.h"

namespace limberg::bone {
namespace {
Outcome refused(std::string why) { return {false, std::move(why)}; }
}  // namespace

Outcome Bones::grab(int32_t id) {
  if (held_ >= 0) return refused("fragment " + std::to_string(held_) + " is held already");
  const Fragment* f = fragment(id);
  if (!f) return refused("there is no fragment " + std::to_string(id));
  for (int32_t i : plated(id))
    if (const Fragment& g = now_.fragments[size_t(i)]; g.fixed) return refused(g.id == id ? g.name + " is fixed" : "it is plated to " + g.name + ", which is fixed");
  before_grab_ = now_;
  held_ = id;
  return {true, ""};
}

void Bones::drag(int32_t id, const Eigen::Isometry3d& wanted) {
  if (id != held_ || held_ < 0) return;
  const Eigen::Isometry3d by = wanted * fragment(id)->pose.inverse();
  for (int32_t i : plated(id)) now_.fragments[size_t(i)].pose = by * now_.fragments[size_t(i)].pose;
}

void Bones::step(double) {}

Outcome Bones::release(int32_t id, bool) {
  if (held_ < 0 || id != held_) return refused("fragment " + std::to_string(id) + " is not held");
  held_ = -1;
  Act act;
  act.before = std::move(before_grab_);
  finish(std::move(act));
  return {true, ""};
}

std::vector<Gap> Bones::gaps() const { return {}; }

}  // namespace limberg::bone
