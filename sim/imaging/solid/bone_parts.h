#pragma once
// Skull, mandible and spine of a bone solid, parted where the least bone holds them together.
//
// In a picture the condyles lie in their sockets and the teeth upon each other with a gap of a voxel or none. So bone
// is a network of its nodes, each tied to its six neighbours as firmly as the bone between them is dense, and is cut
// where the least is cut between what is skull for certain and what is mandible for certain (minimal cut by Boykov and
// Kolmogorov 2004, Boost). For certain are
//
//   skull       what lies around the largest hollow that a ball of 18 mm does not enter from outside: the brain's
//   mandible    what goes on from the chin (the place farthest down and forwards, near the front) at the least
//               density at which that does not go on to the skull
//   spine       bone far behind the front and below the brain's hollow
//
// How firm the cut was is told: no bone at all is certain, much or dense bone is not.
#include <cstdint>
#include <string>
#include <vector>

#include "sim/imaging/solid/bone_solid.h"

namespace limberg {

enum class BonePart : uint8_t { none, skull, mandible, spine };

struct BoneCut {
  bool made = false;
  double area_mm2 = 0;  // of bone that was cut through
  double density = 0;   // its mean, in the numbers of the volume
  double apart_at = 0;  // the least density at which the two are apart
};

struct BoneParts {
  std::vector<BonePart> of;  // of the nodes of the solid
  double skull_cm3 = 0, mandible_cm3 = 0, spine_cm3 = 0, other_cm3 = 0;
  BoneCut mandible, spine;
  Vec3 brain_mm = Vec3::Zero();  // the middle of its hollow
  double brain_cm3 = 0;
  Vec3 chin_mm = Vec3::Zero();
  std::vector<std::string> notes;  // what could not be parted, and why
};

/// The frame of the solid is left, posterior, superior, the head within 45 degrees of upright in it. Throws InputError
/// when there is no hollow for a brain (less than 80 cm3).
BoneParts part_bones(const BoneSolid& solid, double iso, Workers& workers);

/// The solid of one of the parts alone.
BoneSolid only(const BoneSolid& solid, const BoneParts& parts, BonePart part, Workers& workers);

}  // namespace limberg
