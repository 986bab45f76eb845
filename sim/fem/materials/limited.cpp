#include "sim/fem/materials/limited.h"

#include <algorithm>
#include <sstream>

#include "sim/base/error.h"
#include "sim/fem/materials/isotropic.h"

namespace limberg {
namespace {

struct Limits final : PrincipalEnergy {
  double least, most, k;
  Limits(double a, double b, double c) : least(a), most(b), k(c) {}
  PrincipalResponse at(const Vec3& s) const override {
    PrincipalResponse r;
    for (int i = 0; i < 3; ++i) {
      const double over = s[i] > most ? s[i] - most : std::min(s[i] - least, 0.0);
      if (over == 0) continue;
      r.psi += 0.5 * k * over * over, r.d[i] = k * over, r.dd(i, i) = k;
    }
    return r;
  }
  bool defined_everywhere() const override { return true; }
  std::string describe() const override {
    std::ostringstream o;
    o << "stretches from " << least << " to " << most << ", " << k << " kPa beyond";
    return o.str();
  }
};

}  // namespace

LawPtr stretch_limits(double least, double most, double k) {
  if (!(least > 0 && least < 1 && most > 1 && k > 0))
    throw InputError("", 0, "limits of stretch below 1 and above it, and a stiffness above 0 kPa, were expected");
  return std::make_shared<Isotropic>(std::make_shared<Limits>(least, most, k));
}

}  // namespace limberg
