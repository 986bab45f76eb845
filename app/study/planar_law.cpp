#include "app/study/planar_law.h"

#include <Eigen/Eigenvalues>

namespace limberg::study {

namespace {

constexpr double kLeastArea = 0.3, kFacesOverMu = 10;

class PlaneMembrane final : public MaterialLaw {
 public:
  PlaneMembrane(double mu, double faces, double t) : mu_(mu), faces_(faces), t_(t) {}

  Response at(const Mat3& F) const override {
    const Area a = area(F);
    Response r;
    r.energy_kPa = 0.5 * mu_ * (F.topLeftCorner<2, 2>().squaredNorm() + a.g - 3);
    r.P_kPa.topLeftCorner<2, 2>() = mu_ * (F.topLeftCorner<2, 2>() + 0.5 * a.g1 * a.cofactor);
    for (int i = 0; i < 2; ++i) {
      r.P_kPa(i, 2) = faces_ * F(i, 2);
      r.P_kPa(2, i) = faces_ * F(2, i);
      r.energy_kPa += 0.5 * faces_ * (F(i, 2) * F(i, 2) + F(2, i) * F(2, i));
    }
    const double d = F(2, 2) - t_;
    r.P_kPa(2, 2) = faces_ * d;
    r.energy_kPa += 0.5 * faces_ * d * d;
    return r;
  }

  Mat9 tangent_kPa(const Mat3& F, bool project) const override {
    const Area a = area(F);
    using Mat4 = Eigen::Matrix4d;  // in the order 11, 21, 12, 22
    const Eigen::Vector4d c(a.cofactor(0, 0), a.cofactor(1, 0), a.cofactor(0, 1), a.cofactor(1, 1));
    Mat4 turn = Mat4::Zero();  // second derivatives of det F2
    turn(0, 3) = turn(3, 0) = 1, turn(1, 2) = turn(2, 1) = -1;
    Mat4 H = mu_ * (Mat4::Identity() + 0.5 * a.g2 * c * c.transpose() + 0.5 * a.g1 * turn);
    if (project) {
      const Eigen::SelfAdjointEigenSolver<Mat4> eig(H);
      H = eig.eigenvectors() * eig.eigenvalues().cwiseMax(0).asDiagonal() * eig.eigenvectors().transpose();
    }
    Mat9 all = Mat9::Zero();
    constexpr int at[4] = {0, 1, 3, 4};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) all(at[i], at[j]) = H(i, j);
    for (const int i : {2, 5, 6, 7, 8}) all(i, i) = faces_;
    return all;
  }

  std::string describe() const override { return "plane membrane, mu " + std::to_string(mu_) + " kPa"; }

 private:
  struct Area {
    double g, g1, g2;  // of 1/J^2 or what continues it
    Eigen::Matrix2d cofactor;
  };
  static Area area(const Mat3& F) {
    const double J = F(0, 0) * F(1, 1) - F(0, 1) * F(1, 0), b = std::max(J, kLeastArea), d = J - b;
    Area a{1 / (b * b), -2 / (b * b * b), 6 / (b * b * b * b), {}};
    a.g += a.g1 * d + 0.5 * a.g2 * d * d;
    a.g1 += a.g2 * d;
    a.cofactor << F(1, 1), -F(1, 0), -F(0, 1), F(0, 0);
    return a;
  }
  double mu_, faces_, t_;
};

}  // namespace

LawPtr plane_membrane(double mu, double faces, double t) { return std::make_shared<PlaneMembrane>(mu, faces, t); }

std::shared_ptr<const LawCatalogue> laws_with_membrane() {
  auto laws = std::make_shared<LawCatalogue>(*shipped_laws());
  laws->add(
      {"plane-membrane",
       "a membrane that cannot leave its plane (app/study/planar_law.h)",
       {{"mu_kPa", 0, 1e6, true}, {"faces_kPa", 0, 1e8, true}, {"rest_thickness", 0.01, 1}},
       [](const LawCatalogue::Values& v) {
         return LayerLaw{0, plane_membrane(v.number("mu_kPa"), v.number("faces_kPa"), v.number("rest_thickness")), 8};
       }});
  return laws;
}

Material membrane_material(double mu, double prestretch) {
  Material m;
  m.prestretch_along = m.prestretch_across = prestretch;
  m.law = {"plane-membrane",
           {{"mu_kPa", {mu}}, {"faces_kPa", {kFacesOverMu * mu}}, {"rest_thickness", {1 / (prestretch * prestretch)}}}};
  // layer_response() completes lambda with Poisson's ratio, as if the law were alike in all directions: solved here for
  // lambda = mu / 1000.
  const Mat9 C =
      plane_membrane(mu, kFacesOverMu * mu, m.law.constants[2].value[0])->tangent_kPa(Mat3::Identity(), false);
  const double s =
      plane_membrane(mu, kFacesOverMu * mu, m.law.constants[2].value[0])->at(Mat3::Identity()).P_kPa.trace() / 3;
  const double W11 = (C(0, 0) + C(4, 4) + C(8, 8)) / 3, W12 = (C(0, 4) + C(4, 8) + C(0, 8)) / 3,
               shear = 0.5 * (W11 - W12 + s);
  const double share = (1e-3 * mu - s + W12) / (2 * shear);  // nu / (1 - 2 nu)
  m.poisson = share / (1 + 2 * share);
  m.young_kPa = 2 * mu * 1.5;
  return m;
}

}  // namespace limberg::study
