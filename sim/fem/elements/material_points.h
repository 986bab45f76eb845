#pragma once
// The material points of a model: energy, gradient and Hessian of the laws that cells carry beside their stencil.
//
// Everything in double. A law is asked at F M with F = I + sum_a u_a grad N_a; its rest value W(M) is taken off, so an
// undeformed cell has energy 0. A model without points has no list here and costs nothing.
#include <vector>

#include "sim/base/simd.h"
#include "sim/base/workers.h"
#include "sim/fem/elements/cell_scatter.h"
#include "sim/fem/kernels/kernels.h"
#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

class MaterialPoints {
 public:
  MaterialPoints() = default;
  explicit MaterialPoints(const FemModel& model);
  bool empty() const { return cells_.empty(); }
  bool in_no_stencil() const { return points_.empty(); }

  /// Adds dE/du to g and returns the energy. `measure`: adds the norm of every cell's force to w. Same bits for any
  /// number of workers.
  CellSums add(const NodeArray& u, NodeArray& g, bool measure, Workers& workers) const;

 private:
  struct Point {
    Eigen::Matrix<double, 8, 3> BM;  // grad N M
    Mat3 M;
    double volume_mm3 = 0, rest_kPa = 0;
    const MaterialLaw* law = nullptr;
  };
  struct Cell {
    std::array<int32_t, 8> node{};
    int32_t first = 0, last = 0;  // points
    double scale = 1;
    uint8_t corners = 8;  // 4: a tetrahedron
  };
  template <int corners>
  CellSums force(const Cell& cell, const NodeArray& u, bool measure, CellForce& out) const;
  std::vector<LawPtr> laws_;
  std::vector<Point> points_;  // per stencil, in order
  std::vector<Cell> cells_;
  CellScatter scatter_;
  mutable std::vector<CellForce> force_;  // scratch, per cell
  mutable std::vector<CellSums> sums_;
};

/// 24 x 24 tangent of one cell's points at u (corner-major: 3 a + i), for the reference solver. Scale not applied.
Eigen::Matrix<double, 24, 24> points_tangent(const FemModel& model, const Stencil& stencil, const Vec3& cell_mm,
                                             const Eigen::Matrix<double, 8, 3>& u, bool project);
/// Energy and 8 x 3 forces of one cell's points at u. Scale not applied.
double points_force(const FemModel& model, const Stencil& stencil, const Vec3& cell_mm,
                    const Eigen::Matrix<double, 8, 3>& u, Eigen::Matrix<double, 8, 3>& force);
/// D_jl = the mean over i of dP_ij/dF_il of a law at F, projected: how stiff it is against gradients along each axis.
/// Neo-Hookean: mu I.
Mat3 scalar_stiffness_kPa(const MaterialLaw& law, const Mat3& F);
/// What the points add to the scalar matrix of the preconditioner: sum V (grad N M) D (grad N M)^T, D at F = M.
Mat8 points_scalar(const FemModel& model, const Stencil& stencil, const Vec3& cell_mm);

/// A full cell of one law: 2 x 2 x 2 Gauss points, no K; lambda (reparametrised) at the centre; p0 such that a flat
/// piece with the skin normal z rests under a free surface: n . sigma n of the law at M.
Stencil law_stencil(const Vec3& cell_mm, int32_t law, const MaterialLaw& response, double lambda_kPa,
                    double density_kg_mm3 = 1e-6, const Mat3& M = Mat3::Identity());

}  // namespace limberg::fem
