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

/// Most tissue lies within its limits, where the law has nothing to say, and that is known without principal stretches.
class StretchLimits final : public MaterialLaw {
 public:
  StretchLimits(double least, double most, double k)
      : least_(least), most_(most), beyond_(std::make_shared<Limits>(least, most, k)) {}
  Response at(const Mat3& F) const override { return within(F) ? Response{} : beyond_.at(F); }
  Mat9 tangent_kPa(const Mat3& F, bool project) const override {
    return within(F) ? Mat9(Mat9::Zero()) : beyond_.tangent_kPa(F, project);
  }
  std::string describe() const override { return beyond_.describe(); }

 private:
  /// Whether most^2 I - C and C - least^2 I, C = F^T F, are positive definite (Sylvester) and F turns nothing over.
  bool within(const Mat3& F) const {
    const Mat3 C = F.transpose() * F;
    return F.determinant() > 0 && positive(most_ * most_ * Mat3::Identity() - C) &&
           positive(C - least_ * least_ * Mat3::Identity());
  }
  static bool positive(const Mat3& A) {
    return A(0, 0) > 0 && A(0, 0) * A(1, 1) > A(0, 1) * A(0, 1) && A.determinant() > 0;
  }
  double least_, most_;
  Isotropic beyond_;
};

}  // namespace

LawPtr stretch_limits(double least, double most, double k) {
  if (!(least > 0 && least < 1 && most > 1 && k > 0))
    throw InputError("", 0, "limits of stretch below 1 and above it, and a stiffness above 0 kPa, were expected");
  return std::make_shared<StretchLimits>(least, most, k);
}

}  // namespace limberg
