#include "sim/skull/face/face_bundle.h"

#include <cmath>

#include "sim/base/error.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/stable_neo_hookean.h"
#include "sim/fem/model/box_model.h"
#include "sim/geometry/polyline.h"

namespace limberg::simplex {

std::optional<InBundle> bundle_at(std::span<const FaceBundle> bundles, const Vec3& X) {
  for (size_t b = bundles.size(); b-- > 0;) {
    const std::vector<Vec3>& path = bundles[b].path_mm;
    double least_mm = bundles[b].radius_mm;
    std::optional<InBundle> found;
    for (size_t k = 0; k + 1 < path.size(); ++k) {
      const double off_mm = distance_to_segment(X, path[k], path[k + 1]);
      if (off_mm <= least_mm) least_mm = off_mm, found = InBundle{b, k};
    }
    if (found) return found;
  }
  return std::nullopt;
}

LawPtr bundle_law(const FaceBundle& b, size_t piece, double poisson) {
  const auto refuse = [&](const char* why) { throw InputError("", 0, "muscle " + b.name + " " + why); };
  if (piece + 1 >= b.path_mm.size()) refuse("has no path; expected two places or more");
  const Vec3 way = b.path_mm[piece + 1] - b.path_mm[piece];
  if (!(way.norm() > 1e-6)) refuse("has two places of its path at one; expected a way between them");
  if (!(b.radius_mm > 0) || !std::isfinite(b.radius_mm)) refuse("has no thickness; expected a radius above 0 mm");
  if (!(b.young_kPa > 0) || !std::isfinite(b.young_kPa)) refuse("has no stiffness; expected one above 0 kPa");
  const Elastic e = elastic_from_young(b.young_kPa, poisson);
  LawPtr matrix = stable_neo_hookean_full(e.mu_kPa, e.lambda_kPa, e.mu_kPa);
  if (b.k1_kPa == 0) return matrix;
  return sum_of({matrix, dispersed_fibres({b.k1_kPa, b.k2, 0}, {{way.normalized()}})});
}

}  // namespace limberg::simplex
