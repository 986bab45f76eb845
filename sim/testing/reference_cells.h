#pragma once
// A cell of the reference solver: energy, forces and Hessian of fem_model.h in double,
// a cell at a time, nothing left out and nothing in common with the minimiser's
// kernels. Laws at material points and what layers add are asked where they live.
#include <span>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

class ReferenceCells {
 public:
  using Gradients = Eigen::Matrix<double, 8, 3>;
  using Mat24 = Eigen::Matrix<double, 24, 24>;

  explicit ReferenceCells(const FemModel& model);  // which must outlive it
  /// Energy (uJ) relative to rest at displacements u of all
  /// nodes, scale applied; `force`, if any: dE/du of the corners.
  double energy(const HexCell& c, std::span<const Vec3> u, Gradients* force) const;
  /// Corner-major (3 a + i), scale applied. `project`: its parts without their negative eigenvalues.
  Mat24 hessian(const HexCell& c, std::span<const Vec3> u, bool project) const;

 private:
  Mat3 F(const HexCell& c, std::span<const Vec3> u) const { return F_at(B_[size_t(c.stencil)], c, u); }
  static Mat3 F_at(const Gradients& grad_N, const HexCell& c, std::span<const Vec3> u);
  Mat24 stencil_hessian(const HexCell& c, std::span<const Vec3> u, bool project) const;
  Mat24 layers_hessian(const HexCell& c, std::span<const Vec3> u, bool project) const;

  const FemModel& m_;
  // Per stencil:
  std::vector<Gradients> B_;         // where its volume is sampled
  std::vector<Gradients> B_sample_;  // at its sample point: another place only where layers share the cell
  std::vector<Gradients> KX_;
  std::vector<double> mu_sample_;  // share of K that is certainly a stiffness at the sample point
  std::vector<Mat8> K_rest_;       // K without that share
};

}  // namespace limberg::fem
