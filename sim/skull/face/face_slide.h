#pragma once
// Where skin slides on bone: loose tissue beneath the scalp, between galea and periosteum.
//
// A tetrahedron of the finite elements that stands on bone and whose middle lies within radius_mm of at_mm is loose
// tissue instead of fat. It resists what slides over the bone like springs spread over it, so many kPa for each mm:
// a layer of thickness t has the shear modulus kPa_per_mm t. Being lifted or pressed it resists kLift times as hard,
// which keeps scalp under tension on bone to a tenth of a millimetre; as incompressible as fat it would carry skin
// along wherever bone parts beneath it, since its volume would change. A sheet of modulus E' and thickness h that is
// drawn along over it gives way within a length of sqrt(E' h / kPa_per_mm) (Volkersen 1938, shear lag of joints).
// Muscles in it stay what they are (face_bundle.h).
#include <span>
#include <string>

#include "sim/fem/materials/law.h"

namespace limberg::simplex {

inline constexpr double kLift = 20;  // Lamé's first constant over the shear modulus

struct FaceSlide {
  std::string name;
  Vec3 at_mm{0, 0, 0};
  double radius_mm = 60;
  double kPa_per_mm = 0.05;  // a choice: no measurement was found
};

/// Of several that have the place the last one; -1: none.
int slide_at(std::span<const FaceSlide> slides, const Vec3& X_mm);

/// Of a layer between bone and fat of Young's modulus `young_kPa`, which it is never stiffer than. Throws InputError on
/// numbers that are not positive and finite.
LawPtr slide_law(const FaceSlide& slide, double thickness_mm, double young_kPa, double poisson);

}  // namespace limberg::simplex
