#pragma once
// Sparse Cholesky of the scalar matrix, handed on as float panels: order (METIS, or a given one) and supernodes by
// CHOLMOD, numbers by supernodal.h.
#include <memory>
#include <optional>
#include <span>

#include "sim/fem/preconditioner/supernodal.h"

namespace limberg::fem {

struct ScalarFactor {
  PanelFactor panels;
  std::vector<int32_t> node_order;  // node of the model eliminated k-th
};

/// Which columns of the factor make a supernode, by CHOLMOD's analysis: whole numbers only. `order`: rows in
/// elimination order, empty = METIS.
SupernodalShape analyze(const ScalarMatrix& A, std::span<const int32_t> order);

/// Throws std::runtime_error if the matrix is not positive definite. `order`: rows in elimination order, empty = METIS.
ScalarFactor factorize(const ScalarMatrix& A, std::span<const int32_t> order);

/// CHOLMOD's own factor and triangular solve in double, order
/// by METIS: what benches and baselines are measured against.
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

/// CHOLMOD and the BLAS inside it stay on the calling thread: no thread is started, and sums keep their order.
void keep_single_threaded();

}  // namespace limberg::fem
