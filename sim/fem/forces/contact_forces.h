#pragma once
// One-sided springs between places of the tissue, s = n.(x_a - x_b) - gap, with the law of contact_law.h, and
// friction across n where a contact has a hold.
//
// Normals, gaps and what friction may bear stand still while the minimiser works; whoever finds contacts turns them
// between steps. Sums over nodes run in single precision, four numbers at a time; what is summed
// are displacements, a rounding of some 1e-6 mm. The rest is in double. How far each pair is apart is found in
// parallel; forces are handed out in the order of the list, so that no bit depends on the number of workers.
#include <span>
#include <vector>

#include "sim/base/simd.h"
#include "sim/base/workers.h"
#include "sim/fem/forces/contact_law.h"
#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

class ContactForces {
 public:
  ContactForces() = default;
  ContactForces(const FemModel& model, std::span<const Contact> contacts);  // on the calling thread

  /// Throws InputError for a node outside the model, a normal that is not of unit length, a stiffness that is not
  /// positive, a negative softness, or friction without a spring. Whatever it throws, memory that is short included,
  /// leaves no contacts.
  void set(const FemModel& model, std::span<const Contact> contacts, Workers& workers);

  /// Adds the forces to g (as a gradient; fixed nodes included) and returns the energy. `measure`: also adds the norm
  /// of each nodal share to w.
  double add(const NodeArray& u, NodeArray& g, bool measure, Workers& workers);
  double add(const NodeArray& u, NodeArray& g, bool measure);  // on the calling thread
  bool empty() const { return item_.empty(); }
  size_t size() const { return item_.size(); }
  /// s in mm: negative when the two places press on each other.
  double clearance_mm(size_t i, const NodeArray& u) const;
  /// Force in mN along the normal, on point a; never negative.
  double force_mN(size_t i, const NodeArray& u) const;
  /// Of friction, on point a; across the normal.
  Vec3 friction_mN(size_t i, const NodeArray& u) const;

 private:
  struct Item {
    std::array<int32_t, 16> node{};  // a's eight, then b's
    std::array<float, 16> w{};       // positive on a's side, negative on b's; unused: 0
    Vec3 normal = Vec3::UnitZ();
    double k = 0;       // mN/mm
    double soft = 0;    // mm
    double offset = 0;  // s of the undeformed state
  };
  struct Friction {
    Vec3 from = Vec3::Zero();  // x_a - x_b - stick of the undeformed state
    double hold = 0, k = 0;    // mN, mN/mm; hold 0: none
    v4 force = {};             // of the last add, on point a
  };
  static const char* fault_of(const FemModel& model, const Contact& c, Item& item, Friction* friction);
  v4 relative(const Item& it, const NodeArray& u) const;  // displacement of a less that of b
  Push pull(const Item& it, const Friction& f, const v4& relative, v4& force) const;

  std::vector<Item> item_;
  std::vector<Friction> friction_;  // per contact; empty where none has any
  std::vector<float> force_;        // of the last add, per contact
  std::vector<double> energy_;      // of it, per chunk
};

}  // namespace limberg::fem
