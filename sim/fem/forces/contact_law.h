#pragma once
// How hard a contact pushes, and what its friction bears (fem_model.h, Contact). The push begins with zero slope, so
// that neither the minimiser nor a pair that comes or goes ever meets a jump; friction begins where nothing is drawn.

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

/// What holds back a place that has slid by slid_mm >= 0: a spring that bears hold_mN at most. k in mN/mm, above 0.
inline Push friction_pull(double slid_mm, double k, double hold_mN) {
  const double give = hold_mN / k;
  if (slid_mm < give) return {0.5 * k * slid_mm * slid_mm, k * slid_mm, k};
  return {hold_mN * (slid_mm - 0.5 * give), hold_mN, 0};
}

}  // namespace limberg::fem
