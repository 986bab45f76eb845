#pragma once
// Dispersed collagen fibres that only pull (Gasser, Ogden, Holzapfel 2006), without the matrix around them:
//
//   W = sum_families k1 / (2 k2) (exp(k2 E^2) - 1),   E = kappa (I1 - 3) + (1 - 3 kappa)(|F
//                                                     a|^2 - 1), taken as 0 when negative
//
// kappa 0: all fibres along a; 1/3: no direction. Beyond k2 E^2 = 12 (a stiffening of 1.6e5, far past rupture) the
// exponential continues as its second-order Taylor polynomial, so that no number overflows.
#include <vector>

#include "sim/fem/materials/law.h"

namespace limberg {

struct FibreFamily {
  Vec3 direction = Vec3::UnitX();  // at rest, unit; the frame of the law
};

struct FibreConstants {
  double k1_kPa = 0, k2 = 1, kappa = 0;  // kappa in [0, 1/3]
};

/// Throws InputError on constants outside their range, a zero direction or no family.
LawPtr dispersed_fibres(const FibreConstants& constants, std::vector<FibreFamily> families);

/// A sum of laws that share a place: matrix and fibres, say.
LawPtr sum_of(std::vector<LawPtr> parts);

}  // namespace limberg
