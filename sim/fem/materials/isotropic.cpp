#include "sim/fem/materials/isotropic.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "sim/base/elementary.h"

namespace limberg {

Isotropic::Isotropic(std::shared_ptr<const PrincipalEnergy> energy, double a, double b)
    : energy_(std::move(energy)), a_(a), b_(b) {
  const PrincipalResponse rest = energy_->at(Vec3::Ones());
  rest_ = rest.psi;
  k_kPa_ = std::max(rest.dd(0, 0), rest.dd(0, 0) - rest.dd(0, 1));
}

PrincipalResponse Isotropic::at_stretches(const Vec3& s) const {
  if (energy_->defined_everywhere() || s.minCoeff() >= a_) {
    PrincipalResponse r = energy_->at(s);
    r.psi -= rest_;
    return r;
  }
  Vec3 phi = s, d1 = Vec3::Ones(), d2 = Vec3::Zero(), below = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    if (s[i] >= a_) continue;
    const double t = elementary::tanh((a_ - s[i]) / (a_ - b_)), sech2 = 1 - t * t;
    phi[i] = b_ + (a_ - b_) * (1 - t);
    d1[i] = sech2;
    d2[i] = 2 * t * sech2 / (a_ - b_);
    below[i] = a_ - s[i];
  }
  const PrincipalResponse e = energy_->at(phi);
  PrincipalResponse r;
  r.psi = e.psi - rest_;
  for (int i = 0; i < 3; ++i) {
    r.psi += k_kPa_ / (6 * a_) * below[i] * below[i] * below[i];
    r.d[i] = e.d[i] * d1[i] - k_kPa_ / (2 * a_) * below[i] * below[i];
    for (int j = 0; j < 3; ++j) r.dd(i, j) = e.dd(i, j) * d1[i] * d1[j];
    r.dd(i, i) += e.d[i] * d2[i] + k_kPa_ / a_ * below[i];
  }
  return r;
}

MaterialLaw::Response Isotropic::at(const Mat3& F) const {
  const RotationSvd svd = rotation_svd(F);
  const PrincipalResponse r = at_stretches(svd.s);
  return {r.psi, svd.U * r.d.asDiagonal() * svd.V.transpose()};
}

// The tangent in the frame of the singular vectors: a 3 x 3 block for changes of the stretches, and for every pair of
// axes a twist and a flip, with eigenvalues (d_i + d_j)/(s_i + s_j) and (d_i - d_j)/(s_i - s_j).
Mat9 Isotropic::tangent_kPa(const Mat3& F, bool project) const {
  const RotationSvd svd = rotation_svd(F);
  const PrincipalResponse r = at_stretches(svd.s);
  Mat9 H = Mat9::Zero();
  auto add = [&](const Mat3& D, double value) {
    if (value == 0 || (project && value < 0)) return;
    const Mat3 E = svd.U * D * svd.V.transpose();
    const Eigen::Map<const Eigen::Matrix<double, 9, 1>> e(E.data());
    H.noalias() += value * e * e.transpose();
  };
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const double sum = svd.s[i] + svd.s[j], difference = svd.s[i] - svd.s[j];
    // Near s_i = -s_j the energy has a kink that no tangent can show; a floor keeps the number finite.
    const double twist = (r.d[i] + r.d[j]) / (std::fabs(sum) > 1e-6 ? sum : std::copysign(1e-6, sum));
    const double flip =
        std::fabs(difference) > 1e-6 ? (r.d[i] - r.d[j]) / difference : 0.5 * (r.dd(i, i) + r.dd(j, j)) - r.dd(i, j);
    Mat3 D = Mat3::Zero();
    D(i, j) = std::sqrt(0.5), D(j, i) = -std::sqrt(0.5);
    add(D, twist);
    D(j, i) = std::sqrt(0.5);
    add(D, flip);
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eig(r.dd);
  for (int i = 0; i < 3; ++i) add(eig.eigenvectors().col(i).asDiagonal(), eig.eigenvalues()[i]);
  return H;
}

}  // namespace limberg
