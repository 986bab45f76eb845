#include "sim/fem/materials/stable_neo_hookean.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "sim/base/error.h"

namespace limberg {
namespace {

Mat3 cofactor(const Mat3& F) {
  Mat3 c;
  c.col(0) = F.col(1).cross(F.col(2)), c.col(1) = F.col(2).cross(F.col(0)), c.col(2) = F.col(0).cross(F.col(1));
  return c;
}

Mat3 cross_matrix(const Vec3& v) {  // times w: v x w
  Mat3 s;
  s << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return s;
}

class StableNeoHookean final : public MaterialLaw {
 public:
  StableNeoHookean(double mu, double lambda, double p0) : mu_(mu), lambda_(lambda), p0_(p0) {}

  Response at(const Mat3& F) const override {
    const double theta = F.determinant() - 1;
    return {0.5 * mu_ * (F.squaredNorm() - 3) - p0_ * theta + 0.5 * lambda_ * theta * theta,
            mu_ * F + (lambda_ * theta - p0_) * cofactor(F)};
  }

  Mat9 tangent_kPa(const Mat3& F, bool project) const override {
    const double pressure = lambda_ * (F.determinant() - 1) - p0_;
    const Mat3 c = cofactor(F);
    const Eigen::Map<const Eigen::Matrix<double, 9, 1>> v(c.data());
    Mat9 H = mu_ * Mat9::Identity() + lambda_ * v * v.transpose();
    for (int j = 0; j < 3; ++j) {  // d cof / dF: column j is the product of the two that follow it
      const int a = (j + 1) % 3, b = (j + 2) % 3;
      H.block<3, 3>(3 * j, 3 * a) -= pressure * cross_matrix(F.col(b));
      H.block<3, 3>(3 * j, 3 * b) += pressure * cross_matrix(F.col(a));
    }
    if (!project) return H;
    const Eigen::SelfAdjointEigenSolver<Mat9> e(H);
    return e.eigenvectors() * e.eigenvalues().cwiseMax(0.0).asDiagonal() * e.eigenvectors().transpose();
  }

  std::string describe() const override { return "stable neo-Hookean, complete"; }

 private:
  double mu_, lambda_, p0_;
};

}  // namespace

LawPtr stable_neo_hookean_full(double mu, double lambda, double p0) {
  if (!(mu >= 0) || !(lambda >= 0) || !(mu + lambda > 0) || !std::isfinite(mu + lambda + p0))
    throw InputError("", 0, "stable neo-Hookean moduli of at least 0 kPa, not both 0, were expected");
  return std::make_shared<StableNeoHookean>(mu, lambda, p0);
}

}  // namespace limberg
