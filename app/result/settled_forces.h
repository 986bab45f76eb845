#pragma once
// Which samples of a session's forces are forces. A stitch pulls as a spring: while the solver has not caught up with
// the hand, a spring is as long as the last frame left it, and what it then says is no force of the patient. In a live
// session of the shipped rhomboid the sum of all stitches so reaches 78 N in frames that are out of balance, and 1.8 N
// in all others.
#include <span>
#include <vector>

namespace limberg {

/// Relative residual above which a sample's forces are not told: unbalanced forces of 1 % of all internal forces.
inline constexpr double kForcesSettled = 1e-2;

struct SettledForces {
  std::vector<double> sum_N, most_N;  // as they were given; NaN where the tissue was out of balance
  size_t pulling = 0;                 // samples in which a stitch pulls
  size_t unsettled = 0;               // of these, those that are out of balance
};

/// Of a session's series, sample by sample; one without a residual counts as settled.
SettledForces settled_forces(std::span<const double> residual, std::span<const double> sum_N,
                             std::span<const double> most_N);

}  // namespace limberg
