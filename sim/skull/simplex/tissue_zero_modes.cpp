// What the springs of a tissue do not hold.
#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "sim/skull/simplex/tissue.h"

namespace limberg::simplex {
namespace {

bool moves(const Tissue& t, size_t v) { return t.role[v] == TissueRole::inside || t.role[v] == TissueRole::side; }

}  // namespace

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
    // Modes = dofs - rank, and the rank is that of R R^T, a row per spring: the pivots of L D L^T that are not zero.
    // What is added to the diagonal keeps those of dependent springs from being exactly 0; they stay near it.
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
  // A motion whose stiffness is 1e-8 of the largest is free: symmetric
  // patches have such, which are exact but for the smoothing's remainder.
  qr.setThreshold(1e-4);
  z.modes = z.dofs - qr.rank();
  return z;
}

}  // namespace limberg::simplex
