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

Vec3 to_mean(const Tissue& t, size_t v) {
  Vec3 p = Vec3::Zero();
  for (size_t k = 0; k < 4; ++k) p += 0.25 * t.x_mm[size_t(t.nbr[v][k])];
  return p - t.x_mm[v];
}

/// To where the turned rest shape wants the vertex.
Vec3 to_shape(const Tissue& t, size_t v) {
  Vec3 p = Vec3::Zero();
  double sum = 0;
  for (size_t k = 0; k < 4; ++k) p += t.k_mN_per_mm[v][k] * t.x_mm[size_t(t.nbr[v][k])], sum += t.k_mN_per_mm[v][k];
  return sum > 0 ? Vec3(p / sum + t.bent_mm[v] - t.x_mm[v]) : Vec3(Vec3::Zero());
}

/// The rotation nearest to A (in the sense of polar decomposition), from a guess.
Mat3 nearest_rotation(const Mat3& A, Mat3 R) {
  constexpr int kTurns = 4;
  for (int i = 0; i < kTurns; ++i) {
    const Vec3 axis = R.col(0).cross(A.col(0)) + R.col(1).cross(A.col(1)) + R.col(2).cross(A.col(2));
    const double size = std::abs(R.col(0).dot(A.col(0)) + R.col(1).dot(A.col(1)) + R.col(2).dot(A.col(2)));
    if (!(size > 0)) return R;
    const Vec3 w = axis / size;
    const double angle = w.norm();
    if (angle < 1e-12) return R;
    R = Eigen::AngleAxisd(angle, w / angle) * R;
  }
  return R;
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
  t.x0_mm = t.x_mm;
  t.turn.assign(t.nbr.size(), Mat3::Identity());
  t.bent_mm.assign(t.nbr.size(), Vec3::Zero());
  for (size_t v = 0; v < t.nbr.size(); ++v)
    for (size_t k = 0; k < 4; ++k) t.rest_mm[v][k] = (t.x_mm[size_t(t.nbr[v][k])] - t.x_mm[v]).norm();
}

void turn_shape(Tissue& t, Workers& workers) {
  const size_t n = t.nbr.size();
  workers.parallel_for(n, kGrain, [&](size_t b, size_t e) {
    for (size_t v = b; v < e; ++v) {
      Mat3 A = Mat3::Zero();
      for (size_t k = 0; k < 4; ++k) {
        const size_t u = size_t(t.nbr[v][k]);
        A += t.k_mN_per_mm[v][k] * (t.x_mm[u] - t.x_mm[v]) * (t.x0_mm[u] - t.x0_mm[v]).transpose();
      }
      t.turn[v] = nearest_rotation(A, t.turn[v]);
    }
  });
  workers.parallel_for(n, kGrain, [&](size_t b, size_t e) {
    for (size_t v = b; v < e; ++v) {
      Vec3 bent = Vec3::Zero();
      double sum = 0;
      for (size_t k = 0; k < 4; ++k) {
        const size_t u = size_t(t.nbr[v][k]);
        bent += 0.5 * t.k_mN_per_mm[v][k] * ((t.turn[v] + t.turn[u]) * (t.x0_mm[v] - t.x0_mm[u])), sum += t.k_mN_per_mm[v][k];
      }
      t.bent_mm[v] = sum > 0 ? Vec3(bent / sum) : Vec3(Vec3::Zero());
    }
  });
}

TissueStep step(Tissue& t, const TissueLaw& law, Workers& workers) {
  if (!(law.gamma > 0 && law.gamma < 2)) throw InputError("", 0, "gamma of a tissue must lie between 0 and 2");
  if (!std::isfinite(law.alpha) || law.alpha < 0) throw InputError("", 0, "alpha of a tissue must be a finite number, 0 or more");
  if (!(law.shape >= 0 && law.shape <= 1)) throw InputError("", 0, "the share of the shape force must lie between 0 and 1");
  const SpringLaw& s = law.spring;
  if (!(s.knee >= 0) || !(s.ratio >= 1) || !(s.c > 0) || !std::isfinite(s.ratio) || !std::isfinite(s.c))
    throw InputError("", 0, "a spring stiffens: knee 0 or more, ratio 1 or more and c above 0 were expected");
  TissueStep out;
  // Eigenvalues: at most 2 of means, weighted or not, and of springs over the stiffness of their vertex (D^-1 K, Gershgorin).
  const bool springs = law.mode == TissueMode::springs, shaped = law.mode == TissueMode::shape || (springs && law.shape > 0);
  constexpr double lambda = 2;
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
        F = to_mean(t, v);
      } else {
        if (springs)
          if (const double k = stiffness(t, v, s, longest[b / kGrain]); k > 0) {
            // The stiffness is that of where the vertex is: it goes no farther at once than this holds.
            const Vec3 f = (1 - law.shape) / k * spring_force(t, v, s);
            const double reach = kReach * (t.rest_mm[v][0] + t.rest_mm[v][1] + t.rest_mm[v][2] + t.rest_mm[v][3]) / 4, far_mm = f.norm();
            F += far_mm > reach ? Vec3(reach / far_mm * f) : f;
          }
        if (shaped) F += (springs ? law.shape : 1) * to_shape(t, v);
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
  if (law.mode == TissueMode::smoothing) return;
  const double share = law.mode == TissueMode::shape ? 1 : law.shape;
  double longest = 0;
  for (size_t i = 0; i < t.link.size(); ++i) {
    const auto [tv, f] = t.link[i];
    const size_t v = size_t(tv);
    if (size_t(f) >= force_mm.size() || (force_mN && size_t(f) >= force_mN->size())) throw InputError("", 0, "one force per vertex of the face was expected");
    if (share < 1) {
      const Vec3 F = spring_force(t, v, law.spring);
      if (const double k = stiffness(t, v, law.spring, longest); k > 0) force_mm[size_t(f)] += (1 - share) / k * F;
      if (force_mN) (*force_mN)[size_t(f)] += F;
    }
    if (share > 0) force_mm[size_t(f)] += share * to_shape(t, v);
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
  // A motion whose stiffness is 1e-8 of the largest is free: symmetric patches have such, which are exact but for the smoothing's remainder.
  qr.setThreshold(1e-4);
  z.modes = z.dofs - qr.rank();
  return z;
}

}  // namespace limberg::simplex
