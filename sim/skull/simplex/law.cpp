#include "sim/skull/simplex/law.h"

#include <algorithm>
#include <cmath>

#include "sim/base/text.h"

namespace limberg::simplex {
namespace {

constexpr double kMargin = 0.99;  // of the bound: at the bound itself oscillations do not die

}  // namespace

double lambda_max(Constraint c, int rigidity) {
  if (c != Constraint::angle && c != Constraint::curvature) return 2;
  return rigidity <= 1 ? 3 : 2.5;
}

Admission admit(Law law, Excess excess) {
  Admission a;
  const auto refuse = [&](std::string why) {
    a.refused = std::move(why);
    return a;
  };
  if (!(law.gamma > 0 && law.gamma < 2))
    return refuse(text("gamma is %g; damping is stable only between 0 and 2", law.gamma));
  if (!std::isfinite(law.external_stiffness) || law.external_stiffness < 0)
    return refuse("the stiffness of the external force must be a finite number, 0 or more");
  if (!std::isfinite(law.metric_gain) || law.metric_gain < 0 || law.metric_gain > 1)
    return refuse("the gain of the curvature adaptation must lie between 0 and 1");
  if (law.metric_every < 1) return refuse("the metric parameters are adapted every 1 or more iterations");
  if (!(law.max_step_mm > 0)) return refuse("the longest step must be above 0 mm");
  if (law.zone.empty() || law.zone.size() > 65536) return refuse("a law has 1 to 65536 zones");
  const double bound = 2 * (2 - law.gamma);
  for (size_t z = 0; z < law.zone.size(); ++z) {
    ZoneLaw& l = law.zone[z];
    if (!std::isfinite(l.alpha) || l.alpha < 0 || !std::isfinite(l.beta) || l.beta < 0)
      return refuse(text("zone %zu: alpha and beta must be finite numbers, 0 or more", z));
    if (l.rigidity < 1 || l.rigidity > 64)
      return refuse(text("zone %zu: the rigidity is %d edges; 1 to 64 were expected", z, l.rigidity));
    if (l.fixed) continue;
    const double outer = l.beta * law.external_stiffness, lambda = lambda_max(l.constraint, l.rigidity);
    if (outer >= kMargin * bound)
      return refuse(
          text("zone %zu: beta times the stiffness of the external force is %g; stable only below 2 (2 - gamma) = %g",
               z, outer, bound));
    if (l.alpha * lambda + outer < bound) continue;
    const double most = (kMargin * bound - outer) / lambda;
    const std::string why = text(
        "zone %zu: alpha %g times %g, plus beta times stiffness %g, is not below 2 (2 - gamma) = %g; the largest "
        "stable alpha is %.4g",
        z, l.alpha, lambda, outer, bound, most);
    if (excess == Excess::refuse) return refuse(why);
    a.reduced.push_back(why);
    l.alpha = most;
  }
  a.law = std::move(law);
  return a;
}

double stiffness_left(const Law& law) {
  double left = 2 * (2 - law.gamma);
  for (const ZoneLaw& l : law.zone)
    if (!l.fixed)
      left = std::min(left, kMargin * 2 * (2 - law.gamma) - l.alpha * lambda_max(l.constraint, l.rigidity) -
                                l.beta * law.external_stiffness);
  return std::max(0., left);
}

}  // namespace limberg::simplex
