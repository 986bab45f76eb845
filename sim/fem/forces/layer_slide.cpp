#include "sim/fem/forces/layer_slide.h"

namespace limberg::fem {
namespace {

using Vec9 = Eigen::Matrix<double, 9, 1>;

// A function of s = |cof F N|^2 and its derivatives.
struct OfArea {
  double value, slope, bend;
};
OfArea fade(double s) {
  constexpr double least = 0.25;
  if (s >= least) return {1 / s, -1 / (s * s), 2 / (s * s * s)};
  const double d = (s - least) / least;
  return {(1 - d + d * d) / least, (-1 + 2 * d) / (least * least), 2 / (least * least * least)};
}
OfArea stretch(double s, double mu, double lambda) {
  const double L = mu + lambda, D = L + lambda * (s - 1);
  return {-0.5 * mu * L * (s - 1) / D, -0.5 * mu * L * L / (D * D), mu * lambda * L * L / (D * D * D)};
}

Mat3 cross_matrix(const Vec3& v) {  // times x: v cross x
  Mat3 m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

// d(|n|^2 / 2) / df, f = F axes, n = f1 x f2.
Mat3 area_slope(const Mat3& f) {
  const Vec3 n = f.col(0).cross(f.col(1));
  Mat3 a;
  a << f.col(1).cross(n), n.cross(f.col(0)), Vec3::Zero();
  return a;
}

// d2(|n|^2) / df2.
Mat9 area_tangent(const Mat3& f) {
  const Vec3 f1 = f.col(0), f2 = f.col(1), n = f1.cross(f2);
  Eigen::Matrix<double, 3, 9> dn = Eigen::Matrix<double, 3, 9>::Zero();
  dn.leftCols<3>() = -cross_matrix(f2), dn.middleCols<3>(3) = cross_matrix(f1);
  Mat9 H = 2 * dn.transpose() * dn;
  H.block<3, 3>(0, 3) += -2 * cross_matrix(n);  // n . (a x b) = -a . (n x b)
  H.block<3, 3>(3, 0) += 2 * cross_matrix(n);
  return H;
}

// From d2/df2 to d2/dF2.
Mat9 to_lattice(const Mat9& H, const Mat3& axes) {
  Mat9 turn = Mat9::Zero();  // vec f = turn vec F
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) turn.block<3, 3>(3 * b, 3 * a) = axes(a, b) * Mat3::Identity();
  return turn.transpose() * H * turn;
}

}  // namespace

namespace {
// slide/2 x^2 / (x + limit) of slide = 1 and its derivatives by x.
OfArea slip_end(double x) {
  constexpr double limit = 2.5;
  const double d = 1 / (x + limit);
  return {0.5 * x * x * d, 0.5 * x * (x + 2 * limit) * d * d, limit * limit * d * d * d};
}
}  // namespace

LayerEnergy layer_slide(const Mat3& F, const Mat3& axes) {
  const Mat3 f = F * axes, area = area_slope(f);
  const double J = F.determinant();
  const OfArea g = fade(f.col(0).cross(f.col(1)).squaredNorm());
  const double W = 0.5 * J * J * g.value;
  const Mat3 slope = J * g.value * cofactor(F) + J * J * g.slope * area * axes.transpose();
  const OfArea end = slip_end(f.col(2).squaredNorm() - 2 * W);
  return {W + end.value, slope + end.slope * 2 * (f.col(2) * axes.col(2).transpose() - slope)};
}

Mat9 determinant_tangent(const Mat3& F) {
  Mat9 H = Mat9::Zero();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    H.block<3, 3>(3 * i, 3 * j) = -cross_matrix(F.col(k));
    H.block<3, 3>(3 * j, 3 * i) = cross_matrix(F.col(k));
  }
  return H;
}

Mat9 layer_slide_tangent(const Mat3& F, const Mat3& axes) {
  const Mat3 f = F * axes, cof = cofactor(f), area = area_slope(f);  // axes is a rotation: J is the same
  const double J = f.determinant();
  const OfArea g = fade(f.col(0).cross(f.col(1)).squaredNorm());
  const Vec9 dJ = Eigen::Map<const Vec9>(cof.data()), ds = 2 * Eigen::Map<const Vec9>(area.data());
  const Mat9 H = g.value * dJ * dJ.transpose() + J * g.slope * (dJ * ds.transpose() + ds * dJ.transpose()) +
                 0.5 * J * J * g.bend * ds * ds.transpose() + J * g.value * determinant_tangent(f) +
                 0.5 * J * J * g.slope * area_tangent(f);
  const OfArea end = slip_end(f.col(2).squaredNorm() - J * J * g.value);
  Vec9 dx = -2 * (J * g.value * dJ + 0.5 * J * J * g.slope * ds);
  dx.tail<3>() += 2 * f.col(2);
  Mat9 d2x = -2 * H;
  d2x.bottomRightCorner<3, 3>() += 2 * Mat3::Identity();
  return to_lattice(H + end.bend * dx * dx.transpose() + end.slope * d2x, axes);
}

LayerEnergy layer_stretch(const Mat3& F, const Mat3& axes, double p0, double lambda) {
  const Mat3 f = F * axes;
  const OfArea g = stretch(f.col(0).cross(f.col(1)).squaredNorm(), p0, lambda);
  return {g.value, 2 * g.slope * area_slope(f) * axes.transpose()};
}

Mat9 layer_stretch_tangent(const Mat3& F, const Mat3& axes, double p0, double lambda) {
  const Mat3 f = F * axes, area = area_slope(f);
  const OfArea g = stretch(f.col(0).cross(f.col(1)).squaredNorm(), p0, lambda);
  const Vec9 ds = 2 * Eigen::Map<const Vec9>(area.data());
  return to_lattice(g.bend * ds * ds.transpose() + g.slope * area_tangent(f), axes);
}

}  // namespace limberg::fem
