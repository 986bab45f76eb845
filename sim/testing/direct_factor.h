#pragma once
// CHOLMOD's own factor, with the BLAS inside it: what benches and baselines are measured against. The program has
// neither.
#include <memory>
#include <span>

#include "sim/fem/preconditioner/scalar_matrix.h"

namespace limberg::fem {

/// CHOLMOD and the BLAS inside it stay on the calling thread: no thread is started, and sums keep their order.
void keep_single_threaded();

/// Factor and triangular solve in double, order by METIS.
class DirectFactor {
 public:
  /// Throws std::runtime_error if the matrix is not positive definite.
  explicit DirectFactor(const ScalarMatrix& A, bool supernodal = true);
  ~DirectFactor();
  DirectFactor(const DirectFactor&) = delete;
  DirectFactor& operator=(const DirectFactor&) = delete;
  /// Three right-hand sides, column after column, n() numbers each, replaced by the solution.
  void solve(std::span<double> columns);
  size_t numbers() const;  // of the factor, 8 bytes each

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg::fem
