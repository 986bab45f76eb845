#pragma once
// One-sided springs between places of the tissue, in double: energy k/2 min(0, s)^2 with s = n.(x_a - x_b) - gap.
//
// The force k max(0, -s) n on a, and its opposite on b, is continuous; only its slope jumps where the places part. There is
// no friction: nothing acts across n. Normals stand still while the minimiser works; whoever finds contacts turns them
// between steps.
#include <span>
#include <vector>

#include "sim/fem/fem_model.h"
#include "sim/fem/simd.h"

namespace limberg::fem {

class ContactForces {
 public:
  ContactForces() = default;
  /// Throws InputError for a node outside the model, a normal that is not of unit length or a stiffness that is not positive.
  ContactForces(const FemModel& model, std::span<const Contact> contacts);

  /// Adds the forces to g (as a gradient; fixed nodes included) and returns the energy. `measure`: also adds the norm of
  /// each nodal share to w.
  double add(const NodeArray& u, NodeArray& g, bool measure) const;
  bool empty() const { return item_.empty(); }
  size_t size() const { return item_.size(); }
  /// s in mm: negative when the two places press on each other.
  double clearance_mm(size_t i, const NodeArray& u) const;
  /// Force in mN along the normal, on point a; never negative.
  double force_mN(size_t i, const NodeArray& u) const;

 private:
  struct Item {
    Vec3 normal = Vec3::UnitZ();
    double k = 0;       // mN/mm
    double offset = 0;  // s of the undeformed state
    int32_t first = 0, count = 0;
  };
  struct Share {
    int32_t node = 0;
    double w = 0;  // positive on a's side, negative on b's
  };
  std::vector<Item> item_;
  std::vector<Share> share_;
};

}  // namespace limberg::fem
