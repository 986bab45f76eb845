#include "sim/fem/elements/effective_bulk.h"

namespace limberg::fem {
namespace {

constexpr double primal_below = 5;  // lambda / mu at nu = 0.4 (reparametrised: 2 nu / (1 - 2 nu) + 1)

}  // namespace

double penalty_kPa(const Stencil& s) { return (s.slide_kPa != 0 ? 6 : 3) * s.mu_kPa; }

bool uses_multiplier(const Stencil& s, bool augmented) {
  return augmented && s.mu_kPa > 0 && s.lambda_kPa > primal_below * s.mu_kPa * (1 + 1e-9);
}

double effective_bulk_kPa(const Stencil& s, bool augmented) {
  if (!uses_multiplier(s, augmented)) return s.lambda_kPa;
  const double k = penalty_kPa(s);
  return s.lambda_kPa * k / (s.lambda_kPa + k);
}

}  // namespace limberg::fem
