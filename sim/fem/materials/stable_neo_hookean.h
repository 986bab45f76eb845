#pragma once
// The scenes' energy as a law that holds its volume part too, for elements whose points carry all of their energy:
//
//   W = mu/2 (|F|^2 - 3) - p0 (J - 1) + lambda/2 (J - 1)^2
//
// (Smith, de Goes, Kim 2018, without the logarithm; lambda = lambda_Lame + mu). p0 = mu: free of stress at rest. A part
// alone: mu = 0 leaves the change of volume.
#include "sim/fem/materials/law.h"

namespace limberg {

/// Throws InputError unless mu, lambda >= 0, not both 0, all finite.
LawPtr stable_neo_hookean_full(double mu_kPa, double lambda_kPa, double p0_kPa);

}  // namespace limberg
