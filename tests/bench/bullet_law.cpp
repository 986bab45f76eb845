// What of the comparison with Bullet needs no Bullet: its energy and the tetrahedra.
#include <Eigen/Eigenvalues>
#include <cmath>

#include "sim/fem/elements/shaped_cells.h"
#include "sim/fem/model/box_model.h"
#include "tests/bench/bullet_peer.h"

namespace limberg::bench {
namespace {

Mat3 cofactor(const Mat3& F) {
  Mat3 C;
  C.col(0) = F.col(1).cross(F.col(2)), C.col(1) = F.col(2).cross(F.col(0)), C.col(2) = F.col(0).cross(F.col(1));
  return C;
}
Mat3 cross_matrix(const Vec3& v) {
  Mat3 M;
  M << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return M;
}

class BulletLaw final : public MaterialLaw {
 public:
  BulletLaw(double mu, double lambda) : mu_(mu), lambda_(lambda), rest_(density(Mat3::Identity())) {}
  Response at(const Mat3& F) const override {
    const double I = F.squaredNorm();
    const Mat3 C = cofactor(F);
    const double J = F.col(0).dot(C.col(0));
    Response r;
    r.energy_kPa = 0.5 * mu_ * (I - 3 - std::log(I + 1)) + 0.5 * lambda_ * square(J - 1 - 0.75 * mu_ / lambda_) - rest_;
    r.P_kPa = mu_ * (1 - 1 / (I + 1)) * F + (lambda_ * (J - 1) - 0.75 * mu_) * C;
    return r;
  }
  Mat9 tangent_kPa(const Mat3& F, bool project) const override {
    const double I = F.squaredNorm();
    const Mat3 C = cofactor(F);
    const double J = F.col(0).dot(C.col(0)), p = lambda_ * (J - 1) - 0.75 * mu_;
    const Eigen::Map<const Eigen::Matrix<double, 9, 1>> f(F.data()), c(C.data());
    Mat9 H = mu_ * (1 - 1 / (I + 1)) * Mat9::Identity() + 2 * mu_ / square(I + 1) * f * f.transpose() +
             lambda_ * c * c.transpose();
    for (int i = 0; i < 3; ++i) {  // d cof F: blocks of the columns
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      H.block<3, 3>(3 * i, 3 * j) -= p * cross_matrix(F.col(k));
      H.block<3, 3>(3 * i, 3 * k) += p * cross_matrix(F.col(j));
    }
    if (!project) return H;
    Eigen::SelfAdjointEigenSolver<Mat9> eig(H);
    return eig.eigenvectors() * eig.eigenvalues().cwiseMax(0).asDiagonal() * eig.eigenvectors().transpose();
  }
  std::string describe() const override { return "neo-Hookean as Bullet has it"; }

 private:
  static double square(double x) { return x * x; }
  double density(const Mat3& F) const {
    const double I = F.squaredNorm(), J = F.determinant();
    return 0.5 * mu_ * (I - 3 - std::log(I + 1)) + 0.5 * lambda_ * square(J - 1 - 0.75 * mu_ / lambda_);
  }
  double mu_, lambda_, rest_;
};

}  // namespace

LawPtr bullet_law(double mu, double lambda) { return std::make_shared<BulletLaw>(mu, lambda); }

std::array<double, 2> bullet_constants(double young, double poisson) {
  const double mu = young / (2 * (1 + poisson)), lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  return {4.0 / 3 * mu, lambda + 5.0 / 6 * mu};
}

std::vector<std::array<int32_t, 4>> five_tets(const FemModel& m) {
  // Corners of the unit cube by bits; the inner tetrahedron has the even ones, or the odd ones in the mirrored cell.
  constexpr int even[5][4] = {{0, 3, 5, 6}, {1, 0, 3, 5}, {2, 0, 3, 6}, {4, 0, 5, 6}, {7, 3, 5, 6}};
  std::vector<std::array<int32_t, 4>> tets;
  for (const HexCell& c : m.cells) {
    const int flip = (c.at[0] / 2 + c.at[1] / 2 + c.at[2] / 2) % 2;  // mirrored in x
    for (const auto& t : even) {
      std::array<int32_t, 4> n;
      for (size_t i = 0; i < 4; ++i) n[i] = c.node[size_t(t[i] ^ flip)];
      tets.push_back(n);
    }
  }
  return tets;
}

FemModel tet_twin(const FemModel& from, double mu, double lambda) {
  ShapedModel s;
  for (size_t i = 0; i < from.X_mm.size(); ++i) s.add_node(from.X_mm[i], from.fixed[i].any());
  const int32_t law = s.add_law(bullet_law(mu, lambda));
  for (const auto& t : five_tets(from)) s.add_tet(t, law);
  FemModel m = s.finish();
  m.mass_kg = from.mass_kg;
  return m;
}

}  // namespace limberg::bench
