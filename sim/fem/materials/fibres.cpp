#include "sim/fem/materials/fibres.h"

#include <cmath>

#include "sim/base/elementary.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

constexpr double kLargestExponent = 12;

class DispersedFibres final : public MaterialLaw {
 public:
  DispersedFibres(const FibreConstants& c, std::vector<FibreFamily> f)
      : c_(c), families_(std::move(f)), largest_(std::sqrt(kLargestExponent / c.k2)) {}

  Response at(const Mat3& F) const override {
    Response r;
    for (const FibreFamily& f : families_) {
      const Strain e = strain(F, f.direction);
      if (e.E <= 0) continue;
      const Scalar w = energy(e.E);
      r.energy_kPa += w.f;
      r.P_kPa += w.f1 * e.G;
    }
    return r;
  }

  // W'' G G^T + W' d2E: never negative, so there is nothing to project.
  Mat9 tangent_kPa(const Mat3& F, bool) const override {
    Mat9 H = Mat9::Zero();
    for (const FibreFamily& f : families_) {
      const Strain e = strain(F, f.direction);
      if (e.E < 0) continue;
      const Scalar w = energy(e.E);
      const Eigen::Map<const Eigen::Matrix<double, 9, 1>> g(e.G.data());
      H += w.f2 * g * g.transpose();
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          for (int l = 0; l < 3; ++l)
            H(3 * j + i, 3 * l + i) +=
                w.f1 * 2 * ((j == l ? c_.kappa : 0) + (1 - 3 * c_.kappa) * f.direction[j] * f.direction[l]);
    }
    return H;
  }

  std::string describe() const override {
    return "fibres, k1 " + std::to_string(c_.k1_kPa) + " kPa k2 " + std::to_string(c_.k2) + " kappa " +
           std::to_string(c_.kappa);
  }

 private:
  struct Strain {
    double E;
    Mat3 G;  // dE/dF
  };
  Strain strain(const Mat3& F, const Vec3& a) const {
    const Vec3 Fa = F * a;
    return {c_.kappa * (F.squaredNorm() - 3) + (1 - 3 * c_.kappa) * (Fa.squaredNorm() - 1),
            2 * c_.kappa * F + 2 * (1 - 3 * c_.kappa) * Fa * a.transpose()};
  }
  struct Scalar {
    double f, f1, f2;
  };
  Scalar energy(double E) const {
    const double e = std::min(E, largest_), x = elementary::exp(c_.k2 * e * e);
    Scalar s{c_.k1_kPa / (2 * c_.k2) * (x - 1), c_.k1_kPa * e * x, c_.k1_kPa * x * (1 + 2 * c_.k2 * e * e)};
    const double beyond = E - e;
    s.f += s.f1 * beyond + 0.5 * s.f2 * beyond * beyond;
    s.f1 += s.f2 * beyond;
    return s;
  }

  FibreConstants c_;
  std::vector<FibreFamily> families_;
  double largest_;
};

class Sum final : public MaterialLaw {
 public:
  explicit Sum(std::vector<LawPtr> p) : parts_(std::move(p)) {}
  Response at(const Mat3& F) const override {
    Response r;
    for (const LawPtr& p : parts_) {
      const Response q = p->at(F);
      r.energy_kPa += q.energy_kPa;
      r.P_kPa += q.P_kPa;
    }
    return r;
  }
  // Projected part by part: a little more than needed, never less.
  Mat9 tangent_kPa(const Mat3& F, bool project) const override {
    Mat9 H = Mat9::Zero();
    for (const LawPtr& p : parts_) H += p->tangent_kPa(F, project);
    return H;
  }
  std::string describe() const override {
    std::string s;
    for (const LawPtr& p : parts_) s += (s.empty() ? "" : " + ") + p->describe();
    return s;
  }

 private:
  std::vector<LawPtr> parts_;
};

}  // namespace

LawPtr dispersed_fibres(const FibreConstants& c, std::vector<FibreFamily> families) {
  if (!(c.k1_kPa > 0) || !(c.k2 > 0) || !std::isfinite(c.k1_kPa * c.k2))
    throw InputError("", 0, "fibre constants k1 (kPa) and k2 above 0 were expected");
  if (!(c.kappa >= 0 && c.kappa <= 1.0 / 3))
    throw InputError("", 0, "a fibre dispersion kappa between 0 and 1/3 was expected");
  if (families.empty()) throw InputError("", 0, "at least one fibre family was expected");
  for (FibreFamily& f : families) {
    if (!(f.direction.norm() > 1e-12)) throw InputError("", 0, "a fibre direction other than zero was expected");
    f.direction.normalize();
  }
  return std::make_shared<DispersedFibres>(c, std::move(families));
}

LawPtr sum_of(std::vector<LawPtr> parts) { return std::make_shared<Sum>(std::move(parts)); }

}  // namespace limberg
