#pragma once
// The soft tissue of a patient's face as one closed surface that can be cut and sewn: from the skin down to bone, or to
// the depth that matters to a flap.
//
//   depth    at each place of the skin: along its normal to the first bone, at most kFleshDepth_mm, at least
//            kLeastFlesh_mm; never steeper than kFleshSlope, so that bone that begins or ends leaves no step
//   sides    at what of the picture is no skin (kFleshRim_mm from where the skin's mesh ends) and before the ears
//
// So cavities within bone do not matter, nor do airways behind it.
#include <cstdint>
#include <vector>

#include "sim/base/workers.h"
#include "sim/imaging/anatomy/patient_model.h"

namespace limberg {

inline constexpr double kFleshDepth_mm = 14, kLeastFlesh_mm = 4, kFleshRim_mm = 8, kFleshSlope = 0.5;
inline constexpr double kFleshBack_mm = 12;  // before the porions

enum class FleshPart : uint8_t { skin, bone, deep, side };  // deep: where no bone was met
inline constexpr const char* kFleshParts[] = {"skin", "bone", "deep", "side"};

struct PatientFlesh {
  std::vector<Vec3> X_mm;  // frame of the head
  std::vector<Tri> tri;    // outwards counter-clockwise, closed
  std::vector<FleshPart> part;
  double over_bone = 0;  // share of the skin's area
};

/// Some seconds. Throws InputError: there is no skin, or none before the porions.
PatientFlesh make_patient_flesh(const PatientModel& patient, Workers& workers);

}  // namespace limberg
