// Moving a tissue, what it does to the face, and what its springs do not hold.
#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "sim/error.h"
#include "sim/simplex/tissue.h"

namespace limberg::simplex {
namespace {

constexpr size_t kGrain = 1024;
constexpr double kReach = 0.25;  // of a spring's length, in one iteration

bool moves(const Tissue& t, size_t v) { return t.role[v] == TissueRole::inside || t.role[v] == TissueRole::side; }

Vec3 spring_force(const Tissue& t, size_t v, const SpringLaw& law) {  // mN
  Vec3 f = Vec3::Zero();
  for (size_t k = 0; k < 4; ++k) {
    const Vec3 d = t.x_mm[size_t(t.nbr[v][k])] - t.x_mm[v];
    const double l = d.norm();
    if (l > 0) f += t.k_mN_per_mm[v][k] * law.force_over_k0(l, t.rest_mm[v][k]) / l * d;
  }
  return f;
}

/// Sum of the tangent stiffnesses at a vertex, mN/mm; the longest elongation of its springs goes to `longest`.
double stiffness(const Tissue& t, size_t v, const SpringLaw& law, double& longest) {
  double sum = 0;
  for (size_t k = 0; k < 4; ++k) {
    const double l = (t.x_mm[size_t(t.nbr[v][k])] - t.x_mm[v]).norm(), l0 = t.rest_mm[v][k];
    sum += t.k_mN_per_mm[v][k] * law.tangent_over_k0(l, l0);
    if (l0 > 0) longest = std::max(longest, l / l0 - 1);
  }
  return sum;
}

Vec3 weighted(const Tissue& t, size_t v, const std::array<double, 4>& w) {
  Vec3 p = Vec3::Zero();
  for (size_t k = 0; k < 4; ++k) p += w[k] * t.x_mm[size_t(t.nbr[v][k])];
  return p - t.x_mm[v];
}

}  // namespace

double SpringLaw::force_over_k0(double l, double l0) const {
  if (!(l0 > 0)) return 0;
  const double e = (l - l0) / l0;
  switch (kind) {
    case Stiffening::none: return l - l0;
    case Stiffening::biphasic: return e <= knee ? l - l0 : l0 * (knee + ratio * (e - knee));
    case Stiffening::quadratic: return (1 + c * e * e) * (l - l0);
    case Stiffening::exponential: return l0 / c * std::expm1(std::min(c * e, 30.));  // (beyond that the bound has long stopped it)
  }
  return 0;
}

double SpringLaw::tangent_over_k0(double l, double l0) const {
  if (!(l0 > 0)) return 1;
  const double e = (l - l0) / l0;
  switch (kind) {
    case Stiffening::none: return 1;
    case Stiffening::biphasic: return e <= knee ? 1 : std::max(1., ratio);
    case Stiffening::quadratic: return 1 + 3 * c * e * e;
    case Stiffening::exponential: return std::max(1., std::exp(std::min(c * e, 30.)));
  }
  return 1;
}

void record_rest(Tissue& t) {
  t.lift0_mm.clear();
  for (const auto& [v, f] : t.link) t.lift0_mm.push_back(t.x_mm[size_t(v)] - t.x_mm[size_t(t.nbr[size_t(v)][0])]);
  t.lift_mm = t.lift0_mm;
  for (size_t v = 0; v < t.nbr.size(); ++v) {
    // Weights w with sum 1 and sum w_j P_j = P, nearest to 1/4 each: w = 1/4 + A^T (A A^T + eps)^-1 (b - A 1/4).
    Eigen::Matrix4d A;
    double size = 0;
    for (size_t k = 0; k < 4; ++k) {
      const Vec3 d = t.x_mm[size_t(t.nbr[v][k])] - t.x_mm[v];
      t.rest_mm[v][k] = d.norm();
      size = std::max(size, d.norm());
      A.col(int(k)) << d, 1;
    }
    if (!(size > 0)) continue;
    A.topRows<3>() /= size;
    const Eigen::Vector4d q = Eigen::Vector4d::Constant(0.25), b(0, 0, 0, 1);
    const Eigen::Matrix4d M = A * A.transpose() + 1e-9 * Eigen::Matrix4d::Identity();
    Eigen::Vector4d w = q + A.transpose() * M.ldlt().solve(b - A * q);
    w /= w.sum();
    // Far outside its neighbours a vertex would be thrown about by them: the mean is all that is kept then.
    if (!w.allFinite() || w.cwiseAbs().sum() > 1.5) w = q;
    for (size_t k = 0; k < 4; ++k) t.weight[v][k] = w[int(k)];
  }
}

TissueStep step(Tissue& t, const TissueLaw& law, Workers& workers) {
  if (!(law.gamma > 0 && law.gamma < 2)) throw InputError("", 0, "gamma of a tissue must lie between 0 and 2");
  if (!std::isfinite(law.alpha) || law.alpha < 0) throw InputError("", 0, "alpha of a tissue must be a finite number, 0 or more");
  if (!(law.shape >= 0 && law.shape <= 1)) throw InputError("", 0, "the share of the shape force must lie between 0 and 1");
  const SpringLaw& s = law.spring;
  if (!(s.knee >= 0) || !(s.ratio >= 1) || !(s.c > 0) || !std::isfinite(s.ratio) || !std::isfinite(s.c))
    throw InputError("", 0, "a spring stiffens: knee 0 or more, ratio 1 or more and c above 0 were expected");
  TissueStep out;
  // Eigenvalues: means 2; springs over the stiffness of their vertex 2 (D^-1 K, Gershgorin); weights 1 + the sum of their sizes, at most 3.
  const bool springs = law.mode == TissueMode::springs, shaped = law.mode == TissueMode::shape || (springs && law.shape > 0);
  const double lambda = shaped ? 3 : 2;
  // (springs that stiffen on the way do it within an iteration, too: a fifth is kept for that)
  out.alpha = std::min(law.alpha, (springs && s.kind != Stiffening::none ? 0.8 : 0.99) * 2 * (2 - law.gamma) / lambda);
  const size_t n = t.nbr.size();
  std::vector<double> far((n + kGrain - 1) / kGrain, 0), longest(far);
  workers.parallel_for(n, kGrain, [&](size_t b, size_t e) {
    for (size_t v = b; v < e; ++v) {
      if (!moves(t, v)) {
        t.before_mm[v] = t.x_mm[v];
        continue;
      }
      Vec3 F = Vec3::Zero();
      if (law.mode == TissueMode::smoothing) {
        F = weighted(t, v, {0.25, 0.25, 0.25, 0.25});
      } else {
        if (springs)
          if (const double k = stiffness(t, v, s, longest[b / kGrain]); k > 0) {
            // The stiffness is that of where the vertex is: it goes no farther at once than this holds.
            const Vec3 f = (1 - law.shape) / k * spring_force(t, v, s);
            const double reach = kReach * (t.rest_mm[v][0] + t.rest_mm[v][1] + t.rest_mm[v][2] + t.rest_mm[v][3]) / 4, far_mm = f.norm();
            F += far_mm > reach ? Vec3(reach / far_mm * f) : f;
          }
        if (shaped) F += (springs ? law.shape : 1) * weighted(t, v, t.weight[v]);
      }
      const Vec3 d = (1 - law.gamma) * (t.x_mm[v] - t.before_mm[v]) + out.alpha * F;
      t.before_mm[v] = t.x_mm[v] + d;
      far[b / kGrain] = std::max(far[b / kGrain], d.squaredNorm());
    }
  });
  std::swap(t.x_mm, t.before_mm);
  for (double d : far) out.max_move_mm = std::max(out.max_move_mm, std::sqrt(d));
  for (double l : longest) out.longest_elongation = std::max(out.longest_elongation, l);
  return out;
}

void pull_face(const Tissue& t, const TissueLaw& law, std::vector<Vec3>& force_mm, std::vector<Vec3>* force_mN) {
  if (law.mode != TissueMode::springs) return;
  double longest = 0;
  for (size_t i = 0; i < t.link.size(); ++i) {
    const auto [tv, f] = t.link[i];
    const size_t v = size_t(tv);
    if (size_t(f) >= force_mm.size() || (force_mN && size_t(f) >= force_mN->size())) throw InputError("", 0, "one force per vertex of the face was expected");
    const Vec3 F = spring_force(t, v, law.spring);
    if (const double k = stiffness(t, v, law.spring, longest); k > 0) force_mm[size_t(f)] += (1 - law.shape) / k * F;
    if (force_mN) (*force_mN)[size_t(f)] += F;
    if (law.shape > 0) force_mm[size_t(f)] += law.shape * (t.x_mm[size_t(t.nbr[v][0])] + t.lift_mm[i] - t.x_mm[v]);
  }
}

ZeroModes zero_energy_modes(const Tissue& t, int64_t dense_up_to) {
  ZeroModes z;
  std::vector<int32_t> at(t.nbr.size(), -1);
  for (size_t v = 0; v < t.nbr.size(); ++v)
    if (moves(t, v)) at[v] = int32_t(z.dofs), z.dofs += 3;
  std::vector<std::pair<int32_t, int32_t>> spring;
  for (size_t v = 0; v < t.nbr.size(); ++v)
    for (int32_t u : t.nbr[v])
      if (int32_t(v) < u && (at[v] >= 0 || at[size_t(u)] >= 0)) spring.push_back({int32_t(v), u});
  z.springs = int64_t(spring.size());
  if (z.dofs > dense_up_to) {
    // Modes = dofs - rank, and the rank is that of R R^T, a row per spring: the pivots of L D L^T that are not zero. What is added
    // to the diagonal keeps those of dependent springs from being exactly 0; they stay near it.
    constexpr double shift = 1e-9;
    std::vector<Eigen::Triplet<double>> entry;
    for (size_t i = 0; i < spring.size(); ++i) {
      const auto [a, b] = spring[i];
      const Vec3 u = (t.x_mm[size_t(b)] - t.x_mm[size_t(a)]).normalized();
      for (int k = 0; k < 3; ++k) {
        if (at[size_t(a)] >= 0) entry.emplace_back(int(i), at[size_t(a)] + k, -u[k]);
        if (at[size_t(b)] >= 0) entry.emplace_back(int(i), at[size_t(b)] + k, u[k]);
      }
    }
    Eigen::SparseMatrix<double> R(z.springs, z.dofs);
    R.setFromTriplets(entry.begin(), entry.end());
    Eigen::SparseMatrix<double> G = R * R.transpose();
    for (int i = 0; i < G.rows(); ++i) G.coeffRef(i, i) += shift;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(G);
    z.modes = z.dofs - (ldlt.vectorD().array() > 1e3 * shift).count();
    z.estimate = true;
    return z;
  }
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(z.springs, z.dofs);
  for (size_t i = 0; i < spring.size(); ++i) {
    const auto [a, b] = spring[i];
    const Vec3 u = (t.x_mm[size_t(b)] - t.x_mm[size_t(a)]).normalized();
    if (at[size_t(a)] >= 0) R.block<1, 3>(Eigen::Index(i), at[size_t(a)]) = -u.transpose();
    if (at[size_t(b)] >= 0) R.block<1, 3>(Eigen::Index(i), at[size_t(b)]) = u.transpose();
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(R);
  qr.setThreshold(1e-9);
  z.modes = z.dofs - qr.rank();
  return z;
}

}  // namespace limberg::simplex
