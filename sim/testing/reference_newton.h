#pragma once
// Full Newton in double on the same model: the oracle of the tests and the baseline of the speed bench.
//
// Hessian with 3 unknowns per free node, CHOLMOD supernodal (order: METIS on the graph of nodes, expanded), Armijo line
// search. `projected` makes every cell's Hessian positive semi-definite through the eigenvalues of the volumetric part
// in the frame of its singular values (Smith, de Goes, Kim 2018); `adaptive` tries the true Hessian first and projects
// only when it is not positive definite.
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg {

class ReferenceElasticity {
 public:
  /// Weight and loads as the solver's (dead_loads.h), except that a piece that nothing holds keeps them.
  ReferenceElasticity(const FemModel& model, std::span<const Spring> springs, std::span<const Contact> contacts = {},
                      const Vec3& gravity_m_s2 = Vec3::Zero(), std::span<const DeadLoad> loads = {});
  ~ReferenceElasticity();
  ReferenceElasticity(const ReferenceElasticity&) = delete;
  ReferenceElasticity& operator=(const ReferenceElasticity&) = delete;

  /// uJ, as defined in fem_model.h, springs, contacts and what loads have done included; relative to the undeformed
  /// state of the cells.
  double energy(std::span<const Vec3> u) const;
  /// mN at every node, fixed ones included; hanging ones keep theirs.
  double gradient(std::span<const Vec3> u, std::vector<Vec3>& g) const;
  /// Dense 3n x 3n Hessian, fixed nodes included; small models only.
  Eigen::MatrixXd dense_hessian(std::span<const Vec3> u, bool project) const;

  /// Pattern and symbolic factorization, if not yet done: what a bench keeps out of its time.
  void prepare() const;

  struct Settings {
    bool adaptive = true;
    int max_iterations = 100;
    double tolerance = 1e-12;  // |free gradient| over the sum of the norms of the cell forces
    std::function<bool(std::span<const Vec3> u)> on_iterate;  // after each accepted step; return true to stop
  };
  struct Result {
    std::vector<Vec3> u;
    int iterations = 0;
    int failed_factors = 0;
    double residual = 0;
    double energy_uJ = 0;
    bool converged = false;
  };
  Result solve(std::span<const Vec3> start, const Settings& settings) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
