#pragma once
// How hard a contact pushes (fem_model.h, Contact): zero with zero force and zero slope where it begins, so that
// neither the minimiser nor a pair that comes or goes ever meets a jump.

namespace limberg::fem {

struct Push {
  double energy = 0, force = 0, slope = 0;  // uJ, mN, mN/mm; the slope is that of the force against the overlap
};

/// s_mm: clearance, negative inside. k in mN/mm.
inline Push contact_push(double s_mm, double k, double soft_mm) {
  if (!(s_mm < 0)) return {};
  const double p = -s_mm;
  if (p < soft_mm) return {k * p * p * p / (6 * soft_mm), k * p * p / (2 * soft_mm), k * p / soft_mm};
  const double q = p - 0.5 * soft_mm;
  return {0.5 * k * (q * q + soft_mm * soft_mm / 12), k * q, k};
}

}  // namespace limberg::fem
