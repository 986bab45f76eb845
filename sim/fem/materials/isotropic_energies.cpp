// One small struct per energy: value, first and second derivatives in principal stretches.
#include <cmath>
#include <sstream>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/fem/materials/isotropic.h"

namespace limberg {
namespace {

/// J and its derivatives by stretches: the other two multiplied, the third one alone.
struct Volume {
  double J;
  Vec3 d;
  Mat3 dd;
  explicit Volume(const Vec3& s) : J(s.prod()), d(s[1] * s[2], s[2] * s[0], s[0] * s[1]) {
    dd << 0, s[2], s[1], s[2], 0, s[0], s[1], s[0], 0;
  }
};

/// Adds f(J) given f, f' and f''.
void add_volumetric(PrincipalResponse& r, const Volume& v, double f, double f1, double f2) {
  r.psi += f;
  r.d += f1 * v.d;
  r.dd += f2 * v.d * v.d.transpose() + f1 * v.dd;
}

/// mu/2 (I1 - 3) needs no principal axes: P = mu F, everywhere.
class NeoHookean final : public MaterialLaw {
 public:
  explicit NeoHookean(double mu) : mu_(mu) {}
  double modulus_kPa() const { return mu_; }
  Response at(const Mat3& F) const override { return {0.5 * mu_ * (F.squaredNorm() - 3), mu_ * F}; }
  Mat9 tangent_kPa(const Mat3&, bool) const override { return mu_ * Mat9::Identity(); }
  std::string describe() const override { return "neo-Hookean, mu " + std::to_string(mu_) + " kPa"; }

 private:
  double mu_;
};

struct NeoHookeanLog final : PrincipalEnergy {
  double mu, lambda;
  NeoHookeanLog(double m, double l) : mu(m), lambda(l) {}
  PrincipalResponse at(const Vec3& s) const override {
    PrincipalResponse r{0.5 * mu * (s.squaredNorm() - 3), mu * s, mu * Mat3::Identity()};
    const Volume v(s);
    const double l = elementary::log(v.J);
    add_volumetric(r, v, 0.5 * lambda * l * l - mu * l, (lambda * l - mu) / v.J, (lambda * (1 - l) + mu) / (v.J * v.J));
    return r;
  }
  std::string describe() const override { return "neo-Hookean with ln J"; }
};

struct NeoHookeanIsochoric final : PrincipalEnergy {
  double mu, bulk;
  NeoHookeanIsochoric(double m, double k) : mu(m), bulk(k) {}
  PrincipalResponse at(const Vec3& s) const override {
    const Volume v(s);
    const double I = s.squaredNorm(), p = elementary::pow(v.J, -2.0 / 3);
    const double p1 = -2.0 / 3 * p / v.J, p2 = 10.0 / 9 * p / (v.J * v.J);
    PrincipalResponse r;
    r.psi = 0.5 * mu * (I * p - 3);
    r.d = 0.5 * mu * (2 * p * s + I * p1 * v.d);
    r.dd = 0.5 * mu *
           (2 * p * Mat3::Identity() + 2 * p1 * (s * v.d.transpose() + v.d * s.transpose()) +
            I * (p2 * v.d * v.d.transpose() + p1 * v.dd));
    add_volumetric(r, v, 0.5 * bulk * (v.J - 1) * (v.J - 1), bulk * (v.J - 1), bulk);
    return r;
  }
  std::string describe() const override { return "neo-Hookean, isochoric and volumetric"; }
};

struct MooneyRivlin final : PrincipalEnergy {
  double c10, c01;
  MooneyRivlin(double a, double b) : c10(a), c01(b) {}
  PrincipalResponse at(const Vec3& s) const override {
    const Vec3 q = s.cwiseProduct(s);
    const double I1 = q.sum(), I2 = q[0] * q[1] + q[1] * q[2] + q[2] * q[0];
    PrincipalResponse r;
    r.psi = c10 * (I1 - 3) + c01 * (I2 - 3);
    for (int i = 0; i < 3; ++i) {
      const double others = I1 - q[i];
      r.d[i] = 2 * s[i] * (c10 + c01 * others);
      for (int j = 0; j < 3; ++j) r.dd(i, j) = i == j ? 2 * (c10 + c01 * others) : 4 * c01 * s[i] * s[j];
    }
    return r;
  }
  bool defined_everywhere() const override { return true; }
  std::string describe() const override { return "Mooney-Rivlin"; }
};

struct Ogden final : PrincipalEnergy {
  std::vector<OgdenTerm> terms;
  explicit Ogden(std::vector<OgdenTerm> t) : terms(std::move(t)) {}
  PrincipalResponse at(const Vec3& s) const override {
    PrincipalResponse r;
    for (const OgdenTerm& t : terms)
      for (int i = 0; i < 3; ++i) {
        const double p = elementary::pow(s[i], t.alpha - 2);
        r.psi += t.mu_kPa / t.alpha * (p * s[i] * s[i] - 1);
        r.d[i] += t.mu_kPa * p * s[i];
        r.dd(i, i) += t.mu_kPa * (t.alpha - 1) * p;
      }
    return r;
  }
  std::string describe() const override {
    std::ostringstream o;
    o << "Ogden";
    for (const OgdenTerm& t : terms) o << ", mu " << t.mu_kPa << " kPa alpha " << t.alpha;
    return o.str();
  }
};

struct Corotated final : PrincipalEnergy {
  double mu, lambda;
  Corotated(double m, double l) : mu(m), lambda(l) {}
  PrincipalResponse at(const Vec3& s) const override {
    const Vec3 e = s - Vec3::Ones();
    PrincipalResponse r;
    r.psi = mu * e.squaredNorm() + 0.5 * lambda * e.sum() * e.sum();
    r.d = 2 * mu * e + Vec3::Constant(lambda * e.sum());
    r.dd = 2 * mu * Mat3::Identity() + Mat3::Constant(lambda);
    return r;
  }
  bool defined_everywhere() const override { return true; }
  std::string describe() const override { return "linear corotated"; }
};

struct StVenantKirchhoff final : PrincipalEnergy {
  double mu, lambda;
  StVenantKirchhoff(double m, double l) : mu(m), lambda(l) {}
  PrincipalResponse at(const Vec3& s) const override {
    const Vec3 e = 0.5 * (s.cwiseProduct(s) - Vec3::Ones());
    const double trace = e.sum();
    PrincipalResponse r;
    r.psi = mu * e.squaredNorm() + 0.5 * lambda * trace * trace;
    for (int i = 0; i < 3; ++i) {
      const double stress = 2 * mu * e[i] + lambda * trace;
      r.d[i] = stress * s[i];
      for (int j = 0; j < 3; ++j) r.dd(i, j) = lambda * s[i] * s[j];
      r.dd(i, i) += 2 * mu * s[i] * s[i] + stress;
    }
    return r;
  }
  bool defined_everywhere() const override { return true; }
  std::string describe() const override { return "Saint Venant-Kirchhoff"; }
};

void require(bool ok, const char* what) {
  if (!ok) throw InputError("", 0, what);
}

}  // namespace

LawPtr neo_hookean(double mu) {
  require(mu > 0, "a neo-Hookean shear modulus above 0 kPa was expected");
  return std::make_shared<NeoHookean>(mu);
}
double neo_hookean_modulus_kPa(const MaterialLaw& law) {
  const auto* n = dynamic_cast<const NeoHookean*>(&law);
  return n ? n->modulus_kPa() : 0;
}
LawPtr neo_hookean_log_full(double mu, double lambda) {
  require(mu > 0 && lambda >= 0, "a shear modulus above 0 and a lambda of at least 0 kPa were expected");
  return std::make_shared<Isotropic>(std::make_shared<NeoHookeanLog>(mu, lambda));
}
LawPtr neo_hookean_isochoric_full(double mu, double bulk) {
  require(mu > 0 && bulk > 0, "shear and bulk moduli above 0 kPa were expected");
  return std::make_shared<Isotropic>(std::make_shared<NeoHookeanIsochoric>(mu, bulk));
}
LawPtr mooney_rivlin(double c10, double c01) {
  require(c10 >= 0 && c01 >= 0 && c10 + c01 > 0,
          "Mooney-Rivlin constants of at least 0 kPa, not both 0, were expected");
  return std::make_shared<Isotropic>(std::make_shared<MooneyRivlin>(c10, c01));
}
LawPtr ogden(std::vector<OgdenTerm> terms) {
  require(!terms.empty(), "at least one Ogden term was expected");
  double shear = 0;
  for (const OgdenTerm& t : terms) {
    require(t.mu_kPa * t.alpha > 0, "Ogden terms with mu * alpha above 0 were expected");
    shear += 0.5 * t.mu_kPa * t.alpha;
  }
  require(std::isfinite(shear), "finite Ogden constants were expected");
  return std::make_shared<Isotropic>(std::make_shared<Ogden>(std::move(terms)));
}
LawPtr corotated(double mu) {
  require(mu > 0, "a corotated shear modulus above 0 kPa was expected");
  return std::make_shared<Isotropic>(std::make_shared<Corotated>(mu, 0));
}
LawPtr corotated_full(double mu, double lambda) {
  require(mu > 0 && lambda >= 0, "a shear modulus above 0 and a lambda of at least 0 kPa were expected");
  return std::make_shared<Isotropic>(std::make_shared<Corotated>(mu, lambda));
}
LawPtr st_venant_kirchhoff(double mu) {
  require(mu > 0, "a Saint Venant-Kirchhoff shear modulus above 0 kPa was expected");
  return std::make_shared<Isotropic>(std::make_shared<StVenantKirchhoff>(mu, 0));
}
LawPtr st_venant_kirchhoff_full(double mu, double lambda) {
  require(mu > 0 && lambda >= 0, "a shear modulus above 0 and a lambda of at least 0 kPa were expected");
  return std::make_shared<Isotropic>(std::make_shared<StVenantKirchhoff>(mu, lambda));
}

}  // namespace limberg
