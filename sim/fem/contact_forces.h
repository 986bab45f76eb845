#pragma once
// One-sided springs between places of the tissue: energy k/2 min(0, s)^2 with s = n.(x_a - x_b) - gap.
//
// The force k max(0, -s) n on a, and its opposite on b, is continuous; only its slope jumps where the places part. There is
// no friction: nothing acts across n. Normals stand still while the minimiser works; whoever finds contacts turns them
// between steps. Sums over nodes run in single precision, four numbers at a time; what is summed are displacements, a
// rounding of some 1e-6 mm. The rest is in double.
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
    std::array<int32_t, 16> node{};  // a's eight, then b's
    std::array<float, 16> w{};       // positive on a's side, negative on b's; unused: 0
    Vec3 normal = Vec3::UnitZ();
    double k = 0;       // mN/mm
    double offset = 0;  // s of the undeformed state
  };
  std::vector<Item> item_;
};

}  // namespace limberg::fem
