#include "sim/measure/skin_strain.h"

#include <algorithm>
#include <cmath>

#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

using Mat2 = Eigen::Matrix2d;
constexpr double kSliver_mm = 0.02;

// Eigenvalues of a symmetric 2 x 2 matrix, largest first.
std::array<double, 2> eigenvalues(const Mat2& S) {
  const double m = 0.5 * (S(0, 0) + S(1, 1)), d = 0.5 * (S(0, 0) - S(1, 1)), r = std::hypot(d, 0.5 * (S(0, 1) + S(1, 0)));
  return {m + r, m - r};
}

}  // namespace

MembraneState membrane_state(const std::array<Vec3, 3>& X, const std::array<Vec3, 3>& x, const Material& material, const Vec3& along) {
  MembraneState s;
  const Vec3 n2 = area_vector2(X[0], X[1], X[2]);
  s.area_mm2 = 0.5 * n2.norm();
  if (!(s.area_mm2 > 0)) return s;
  const Vec3 n = n2.normalized();
  Vec3 e1 = along - along.dot(n) * n;
  if (e1.norm() < 1e-3 * along.norm()) e1 = X[1] - X[0];
  e1.normalize();
  const Vec3 e2 = n.cross(e1);

  // F^T F in the axes e1, e2.
  Mat2 E;
  E << (X[1] - X[0]).dot(e1), (X[2] - X[0]).dot(e1), (X[1] - X[0]).dot(e2), (X[2] - X[0]).dot(e2);
  Eigen::Matrix<double, 3, 2> e;
  e << x[1] - x[0], x[2] - x[0];
  const Eigen::Matrix<double, 3, 2> F = e * E.inverse();
  const Mat2 C = F.transpose() * F;
  const double p = material.prestretch_along, q = material.prestretch_across;
  Mat2 B;  // sqrt(A) C sqrt(A)
  B << p * p * C(0, 0), p * q * C(0, 1), p * q * C(1, 0), q * q * C(1, 1);
  const auto b = eigenvalues(B);
  s.stretch = std::sqrt(std::max(0.0, b[0]));
  s.least_stretch = std::sqrt(std::max(0.0, b[1]));

  const double det = std::sqrt(std::max(0.0, C.determinant()));
  if (det < 1e-6) return s;
  const double mu = material.mu_kPa(), lambda = material.lambda_kPa() + mu, a_nn = 1 / (p * p * q * q);
  const double thick = (mu * a_nn + lambda) / (mu * a_nn / det + lambda * det), J = det * thick;
  const double s1 = mu / J * (b[0] - a_nn * thick * thick), s2 = mu / J * (b[1] - a_nn * thick * thick);
  s.stress_kPa = s1;
  s.von_mises_kPa = std::sqrt(std::max(0.0, s1 * s1 - s1 * s2 + s2 * s2));
  return s;
}

double weighted_percentile(std::vector<std::pair<double, double>>& pairs, double q) {
  if (pairs.empty()) return 0;
  std::sort(pairs.begin(), pairs.end());
  double total = 0, sum = 0;
  for (const auto& [v, w] : pairs) total += w;
  for (const auto& [v, w] : pairs) {
    sum += w;
    if (sum >= q * total) return v;
  }
  return pairs.back().first;
}

SkinStrain skin_strain(const SurfaceView& view, std::span<const Vec3f> x_mm, const Body& body) {
  SkinStrain s;
  if (body.layers.empty()) return s;
  std::vector<std::pair<double, double>> stretch, stress;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    std::array<Vec3, 3> X, x;
    for (size_t k = 0; k < 3; ++k) {
      X[k] = view.X_mm[size_t(view.tri[t][k])];
      x[k] = x_mm[size_t(view.tri[t][k])].cast<double>();
    }
    const double longest = std::max({(X[1] - X[0]).norm(), (X[2] - X[1]).norm(), (X[0] - X[2]).norm()});
    if (area_vector2(X[0], X[1], X[2]).norm() < kSliver_mm * longest) continue;
    const MembraneState m = membrane_state(X, x, body.layers[0].material, body.tension_direction);
    stretch.push_back({m.stretch, m.area_mm2});
    stress.push_back({m.stress_kPa, m.area_mm2});
    if (m.stress_kPa > s.stress_max_kPa || s.area_mm2 == 0) {
      s.stress_max_kPa = m.stress_kPa;
      s.most_stressed_mm = (X[0] + X[1] + X[2]) / 3;
    }
    s.stretch_max = s.area_mm2 == 0 ? m.stretch : std::max(s.stretch_max, m.stretch);
    s.area_mm2 += m.area_mm2;
  }
  if (stretch.empty()) return s;
  s.stretch_p99 = weighted_percentile(stretch, 0.99);
  s.stress_p95_kPa = weighted_percentile(stress, 0.95);
  return s;
}

}  // namespace limberg
