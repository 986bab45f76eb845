#pragma once
// Isotropic laws from energies in principal stretches, continued through inversion.
//
// An energy gives psi(s1, s2, s3), symmetric in its arguments, with first and
// second derivatives, for positive stretches. Isotropic turns it into a law:
// P = U diag(dpsi/ds) V^T with the rotation-variant singular values s of F
// (the third one is negative when F is inverted; Irving, Teran, Fedkiw 2004).
//
// Inversion. Below the stretch `a` the energy is asked at phi(s) instead, and a spring takes over:
//
//   psi_ext(s) = psi(phi(s1), phi(s2), phi(s3)) + sum_i k/6 ((a - s_i)+)^3 / a
//   phi(s) = s for s >= a;  b + (a - b)(1 - tanh((a - s)/(a - b))) below: twice differentiable, always above b > 0
//
// It is an energy, twice differentiable, defined everywhere, the same as psi where all stretches are above a, and it
// grows without bound as a cell is turned inside out: so a line search always works and an inverted cell comes back
// (Stomakhin et al. 2012 extend by a Taylor series instead, which needs third derivatives of every energy).
#include <memory>
#include <string>
#include <vector>

#include "sim/fem/materials/law.h"
#include "sim/fem/materials/rotation_svd.h"

namespace limberg {

struct PrincipalResponse {
  double psi = 0;          // kPa
  Vec3 d = Vec3::Zero();   // dpsi / ds_i
  Mat3 dd = Mat3::Zero();  // d^2 psi / ds_i ds_j
};

class PrincipalEnergy {
 public:
  virtual ~PrincipalEnergy() = default;
  /// All stretches positive.
  virtual PrincipalResponse at(const Vec3& stretch) const = 0;
  virtual std::string describe() const = 0;
  /// True for energies that are smooth for every real stretch: no continuation is needed or applied.
  virtual bool defined_everywhere() const { return false; }
};

class Isotropic final : public MaterialLaw {
 public:
  /// Stretches below `a` are continued; phi never falls below `b`. k is taken from the energy at rest.
  explicit Isotropic(std::shared_ptr<const PrincipalEnergy> energy, double a = 0.3, double b = 0.1);
  Response at(const Mat3& F) const override;
  Mat9 tangent_kPa(const Mat3& F, bool project) const override;
  std::string describe() const override { return energy_->describe(); }
  /// The continued energy at signed stretches.
  PrincipalResponse at_stretches(const Vec3& s) const;

 private:
  std::shared_ptr<const PrincipalEnergy> energy_;
  double a_, b_, k_kPa_ = 0, rest_ = 0;
};

// --- Energies. mu, c, mu_p in kPa; the volume part (if any) is
// inside only where the name says `full`. --------------------

/// mu/2 (I1 - 3)
LawPtr neo_hookean(double mu_kPa);
/// Its mu, if the law is that one; otherwise 0. For loops that know its closed form.
double neo_hookean_modulus_kPa(const MaterialLaw& law);
/// mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2 (Bonet, Wood). Complete.
LawPtr neo_hookean_log_full(double mu_kPa, double lambda_kPa);
/// mu/2 (I1 J^-2/3 - 3) + K/2 (J - 1)^2 (as CalculiX and Abaqus have it). Complete.
LawPtr neo_hookean_isochoric_full(double mu_kPa, double bulk_kPa);
/// c10 (I1 - 3) + c01 (I2 - 3)
LawPtr mooney_rivlin(double c10_kPa, double c01_kPa);
struct OgdenTerm {
  double mu_kPa = 0, alpha = 2;
};
/// sum mu_p / alpha_p (s1^alpha_p + s2^alpha_p + s3^alpha_p - 3); shear modulus at rest sum mu_p alpha_p / 2.
LawPtr ogden(std::vector<OgdenTerm> terms);
/// mu |F - R|^2 (the rotated linear law without its volume part)
LawPtr corotated(double mu_kPa);
/// mu |F - R|^2 + lambda/2 (tr(R^T F) - 3)^2. Complete.
LawPtr corotated_full(double mu_kPa, double lambda_kPa);
/// mu |E|^2, E = (F^T F - I)/2
LawPtr st_venant_kirchhoff(double mu_kPa);
/// mu |E|^2 + lambda/2 (tr E)^2. Complete. It softens under compression below 0.58: for comparison only.
LawPtr st_venant_kirchhoff_full(double mu_kPa, double lambda_kPa);

}  // namespace limberg
