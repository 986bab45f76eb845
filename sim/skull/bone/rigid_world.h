#pragma once
// The Bullet world of the fragments while one of them is held, or one in each hand. No Bullet header is included here,
// and no Bullet is loaded before the first world is made: it is a part of its own (base/part.h,
// bullet/bullet_world.cpp).
//
// A fragment is a compound of convex pieces: under every face of its surface a prism, from
// kInset_mm under the surface to at most kThick_mm (never more than 45 % of the bone's thickness
// there). So thin curved shells stay hollow, and a fragment rests in its own gap without
// touching: two surfaces touch when they overlap by 2 kInset_mm, about the kerf of a saw.
//
// step() goes in so many substeps that no place of a held body moves further than kStride_mm in one
// of them, which is less than the prisms are thick: nothing tunnels, at any speed. In each substep
// a held body gets the velocity that takes it to where its hand wants it; contact takes back what
// would lead into other bone. Fragments that are not held are pushed aside, and stop at once (no
// inertia worth the name, no gravity). One solver, fixed order, no threads: same calls, same bits.
//
// Bullet computes in floats; lengths are in cm there, so that its tolerances (tuned for bodies of 0.05 to 10) fit.
#include <memory>
#include <string>
#include <vector>

#include "sim/geometry/vec.h"
#include "sim/skull/bone/bones.h"

namespace limberg::bone {

/// The places that a convex piece spans, in the frame of rest; Bullet adds kMargin_mm around it.
using Prism = std::vector<Vec3>;

struct RigidPart {
  std::vector<const std::vector<Prism>*> prisms;  // of all fragments that move as one, and
  std::vector<Eigen::Isometry3d> offset;          // where each of them is in the part's frame
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  Vec3 centre_mm = Vec3::Zero();  // in the part's frame
  double mass_g = 1;
  bool fixed = false;
};

class RigidWorld {
 public:
  static constexpr double kInset_mm = 0.25, kMargin_mm = 0.1, kThick_mm = 2, kStride_mm = 0.4;
  static constexpr int kMostSubsteps = 64;

  virtual ~RigidWorld() = default;
  virtual void want(size_t part, const Eigen::Isometry3d& pose) = 0;  // of a held one
  virtual void step(double dt_s) = 0;
  virtual Eigen::Isometry3d pose(size_t part) const = 0;
  virtual RigidFigures figures() const = 0;
};

/// Why no fragment can be held here: what is missing and what was expected. Empty: they can.
std::string why_no_physics();

/// `held`: indices into parts, at least one. Throws std::runtime_error with why_no_physics().
std::unique_ptr<RigidWorld> make_rigid_world(const std::vector<RigidPart>& parts, const std::vector<size_t>& held);

}  // namespace limberg::bone
