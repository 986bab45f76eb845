#pragma once
// What contact remembers of a moment: undo and redo bring it back with everything else.
#include <array>
#include <cstdint>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// What friction has hold of (contact_friction.h).
struct Grip {
  Vec3 stick_mm = Vec3::Zero();  // x_a - x_b, as the cells carry them, from where what is drawn across counts
  double push_mN = 0;            // that friction goes by; 0: it holds nothing
};

/// A pair of a place and a sheet as it is now.
struct HeldContact {
  int32_t place = 0, sheet = -1, triangle = -1;
  std::array<double, 3> bary{};
  Vec3 normal = Vec3::UnitZ();   // of the plane
  Vec3 facet = Vec3::UnitZ();    // the sheet's normal at the foot when the pair was found
  Vec3 apart_mm = Vec3::Zero();  // of place and foot as the cells carry them, when it was found
  double gap_mm = 0;          // s = normal . apart - gap: clearance of the surfaces as they are shown; negative inside
  double weight = 0;          // 0 to 1
  bool depth_tested = false;  // its weight says how deep the place is, and which way is out; else it is in front
  Grip grip;
};

/// A place of the surface and the plane of a collider that it is kept out of (collider_contacts.h).
struct HeldByCollider {
  int32_t place = 0, projections = 0;
  Vec3 slid_mm = Vec3::Zero();  // along its planes, within its present neighbourhood
  Vec3 normal = Vec3::UnitZ();  // away from the collider
  double plane_mm = 0;          // normal . x of the plane
  Vec3 at_mm = Vec3::Zero();    // the place when it was projected
  Grip grip;
};

/// What a finder must get back to go on as it would have. A place that is not named is fresh.
struct ContactMemory {
  struct Damping {
    int32_t place = 0, projections = 0;  // in the neighbourhood that it has slid through so far
    Vec3 slid_mm = Vec3::Zero();
  };
  std::vector<HeldContact> pairs;         // by place, then sheet
  std::vector<Damping> damping;           // by place
  std::vector<HeldByCollider> colliders;  // by place
};

}  // namespace limberg
