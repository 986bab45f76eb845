#include "sim/measure/skin_strain.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/body/tension_lines.h"
#include "sim/fem/materials/catalogue.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

using Mat2 = Eigen::Matrix2d;
constexpr double kSliver_mm = 0.02;

// Eigenvalues of a symmetric 2 x 2 matrix, largest first.
std::array<double, 2> eigenvalues(const Mat2& S) {
  const double m = 0.5 * (S(0, 0) + S(1, 1)), d = 0.5 * (S(0, 0) - S(1, 1)),
               r = elementary::hypot(d, 0.5 * (S(0, 1) + S(1, 0)));
  return {m + r, m - r};
}

// What of a triangle both need.
struct InPlane {
  MembraneState s;
  Mat2 C;          // F^T F in the axes along and across
  Mat2 B;          // the same with prestretch, sqrt(A) C sqrt(A)
  double det = 0;  // sqrt(det C); 0: nothing but s is known
};

InPlane in_plane(const std::array<Vec3, 3>& X, const std::array<Vec3, 3>& x, const Material& material,
                 const Vec3& along) {
  InPlane r;
  const Vec3 n2 = area_vector2(X[0], X[1], X[2]);
  r.s.area_mm2 = 0.5 * n2.norm();
  if (!(r.s.area_mm2 > 0)) return r;
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
  r.C = F.transpose() * F;
  const double p = material.prestretch_along, q = material.prestretch_across;
  r.B << p * p * r.C(0, 0), p * q * r.C(0, 1), p * q * r.C(1, 0), q * q * r.C(1, 1);
  const auto b = eigenvalues(r.B);
  r.s.stretch = std::sqrt(std::max(0.0, b[0]));
  r.s.least_stretch = std::sqrt(std::max(0.0, b[1]));
  const double det = std::sqrt(std::max(0.0, r.C.determinant()));
  if (det >= 1e-6) r.det = det;
  return r;
}

// T: stress (up to a positive factor) in axes turned with the tissue; U: its stretch, so that fibres lie along U e1.
double angle_to_fibres_deg(const Mat2& T, const Mat2& U, double s1, double s2) {
  if (!(std::abs(s1 - s2) > 0.02 * std::abs(s1))) return -1;
  const double most = 0.5 * elementary::atan2(T(0, 1) + T(1, 0), T(0, 0) - T(1, 1)),
               fibre = elementary::atan2(U(1, 0), U(0, 0));
  const double d = std::abs(std::remainder(most - fibre, std::numbers::pi));
  return d * 180 / std::numbers::pi;
}

// F as a symmetric stretch in the plane: sqrt of a 2 x 2 matrix is (C + det I) / sqrt(trace + 2 det).
Mat2 stretch_of(const InPlane& r) { return (r.C + r.det * Mat2::Identity()) / std::sqrt(r.C.trace() + 2 * r.det); }

void set_stress(MembraneState& s, double s1, double s2) {
  s.stress_kPa = s1;
  s.least_stress_kPa = s2;
  s.von_mises_kPa = std::sqrt(std::max(0.0, s1 * s1 - s1 * s2 + s2 * s2));
}

}  // namespace

MembraneState membrane_state(const std::array<Vec3, 3>& X, const std::array<Vec3, 3>& x, const Material& material,
                             const Vec3& along) {
  InPlane r = in_plane(X, x, material, along);
  if (r.det == 0) return r.s;
  const auto b = eigenvalues(r.B);
  const double p = material.prestretch_along, q = material.prestretch_across;
  const double mu = material.mu_kPa(), lambda = material.lambda_kPa() + mu, a_nn = 1 / (p * p * q * q);
  const double thick = (mu * a_nn + lambda) / (mu * a_nn / r.det + lambda * r.det), J = r.det * thick;
  set_stress(r.s, mu / J * (b[0] - a_nn * thick * thick), mu / J * (b[1] - a_nn * thick * thick));
  const Mat2 U = stretch_of(r);
  r.s.angle_deg =
      angle_to_fibres_deg(U * Eigen::Vector2d(p * p, q * q).asDiagonal() * U, U, r.s.stress_kPa, r.s.least_stress_kPa);
  return r.s;
}

MembraneState membrane_state(const std::array<Vec3, 3>& X, const std::array<Vec3, 3>& x, const Material& material,
                             const Vec3& along, const LayerResponse& law) {
  InPlane r = in_plane(X, x, material, along);
  if (r.det == 0) return r.s;
  const double p = material.prestretch_along, q = material.prestretch_across;
  const Mat3 M = Vec3(p, q, 1 / (p * q)).asDiagonal();
  const double p0 = rest_pressure_kPa(law, M, Vec3::UnitZ());
  const Mat2 U = stretch_of(r);
  const auto cauchy = [&](double thick) {
    Mat3 F = Mat3::Zero();
    F.topLeftCorner<2, 2>() = U, F(2, 2) = thick;
    const double J = r.det * thick;
    return Mat3(law.whole->at(F * M).P_kPa * (F * M).transpose() / J +
                (law.lambda_kPa * (J - 1) - p0) * Mat3::Identity());
  };
  double lo = 0.2 / r.det, hi = 3 / r.det;  // J between 0.2 and 3; the stress across rises with the thickness
  for (int k = 0; k < 40; ++k) {
    const double mid = 0.5 * (lo + hi);
    (cauchy(mid)(2, 2) > 0 ? hi : lo) = mid;
  }
  const Mat2 T = cauchy(0.5 * (lo + hi)).topLeftCorner<2, 2>();
  const auto e = eigenvalues(T);
  set_stress(r.s, e[0], e[1]);
  r.s.angle_deg = angle_to_fibres_deg(T, U, e[0], e[1]);
  return r.s;
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

namespace {

/// The least value that no more than so much of the weight lies above; sorts `pairs`. 0 when empty.
double all_but(std::vector<std::pair<double, double>>& pairs, double weight) {
  if (pairs.empty()) return 0;
  std::sort(pairs.begin(), pairs.end());
  double above = 0;
  for (size_t i = pairs.size(); i-- > 1;)
    if ((above += pairs[i].second) > weight) return pairs[i].first;
  return pairs.front().first;
}

}  // namespace

std::vector<MembraneState> skin_states(const SurfaceView& view, std::span<const Vec3f> x_mm, const Body& body) {
  std::vector<MembraneState> out(view.tri.size());
  if (body.layers.empty()) return out;
  const Material& material = body.layers[0].material;
  const LayerResponse law = layer_response(material, body.laws.get());
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    std::array<Vec3, 3> X, x;
    for (size_t k = 0; k < 3; ++k) {
      X[k] = view.X_mm[size_t(view.tri[t][k])];
      x[k] = x_mm[size_t(view.tri[t][k])].cast<double>();
    }
    const double longest = std::max({(X[1] - X[0]).norm(), (X[2] - X[1]).norm(), (X[0] - X[2]).norm()});
    if (area_vector2(X[0], X[1], X[2]).norm() < kSliver_mm * longest) continue;
    const Vec3 along = body.tension.empty() ? body.tension_direction
                                            : tension_along(body, view.origin[t], Vec3((X[0] + X[1] + X[2]) / 3));
    out[t] = law.points ? membrane_state(X, x, material, along, law) : membrane_state(X, x, material, along);
  }
  return out;
}

SkinStrain skin_strain(const SurfaceView& view, std::span<const Vec3f> x_mm, const Body& body) {
  SkinStrain s;
  const std::vector<MembraneState> states = skin_states(view, x_mm, body);
  std::vector<std::pair<double, double>> stretch, stress;  // stress: within the law's range
  for (const MembraneState& m : states) {
    if (!(m.area_mm2 > 0)) continue;
    stretch.push_back({m.stretch, m.area_mm2});
    s.area_mm2 += m.area_mm2;
    if (m.least_stress_kPa < 0) s.compressed_mm2 += m.area_mm2;
    if (!beyond_law(m))
      stress.push_back({m.stress_kPa, m.area_mm2});
    else
      s.beyond_law_mm2 += m.area_mm2;
  }
  if (stretch.empty()) return s;
  s.stretch_p99 = weighted_percentile(stretch, 0.99);
  s.stretch_max = all_but(stretch, kLargest_mm2);
  // Sorted by all_but; what is beyond ranks above them.
  s.stress_max_kPa = all_but(stress, kLargest_mm2 - s.beyond_law_mm2);
  const double within = s.area_mm2 - s.beyond_law_mm2;
  s.stress_p95_kPa = within > 0 ? weighted_percentile(stress, std::min(1.0, 0.95 * s.area_mm2 / within)) : 0;
  for (size_t t = 0; t < states.size(); ++t)
    if (states[t].area_mm2 > 0 && !beyond_law(states[t]) && states[t].stress_kPa == s.stress_max_kPa)
      s.most_stressed_mm =
          (view.X_mm[size_t(view.tri[t][0])] + view.X_mm[size_t(view.tri[t][1])] + view.X_mm[size_t(view.tri[t][2])]) /
          3;
  double sum = 0, area = 0;
  for (const MembraneState& m : states)
    if (m.area_mm2 > 0 && !beyond_law(m) && m.stress_kPa >= s.stress_p95_kPa && m.angle_deg >= 0)
      sum += m.angle_deg * m.area_mm2, area += m.area_mm2;
  if (area > 0) s.angle_deg = sum / area;
  return s;
}

}  // namespace limberg
