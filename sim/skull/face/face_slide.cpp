#include "sim/skull/face/face_slide.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/fem/materials/stable_neo_hookean.h"
#include "sim/fem/model/box_model.h"

namespace limberg::simplex {

int slide_at(std::span<const FaceSlide> slides, const Vec3& X) {
  for (size_t k = slides.size(); k-- > 0;)
    if ((X - slides[k].at_mm).norm() <= slides[k].radius_mm) return int(k);
  return -1;
}

LawPtr slide_law(const FaceSlide& s, double thickness_mm, double young_kPa, double poisson) {
  const auto positive = [&](double x, const char* what) {
    if (!(x > 0) || !std::isfinite(x))
      throw InputError("", 0, "slide " + s.name + " has no " + what + "; expected one above 0");
  };
  positive(s.radius_mm, "size"), positive(s.kPa_per_mm, "stiffness"), positive(thickness_mm, "thickness");
  const Elastic fat = elastic_from_young(young_kPa, poisson);
  const double mu = std::min(s.kPa_per_mm * thickness_mm, fat.mu_kPa);
  return stable_neo_hookean_full(mu, std::min(kLift * mu, fat.lambda_kPa), mu);
}

}  // namespace limberg::simplex
