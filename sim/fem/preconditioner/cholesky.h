#pragma once
// Sparse Cholesky of the scalar matrix, handed on as float panels: order (METIS, or a given one) and supernodes by
// CHOLMOD, numbers by supernodal.h.
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

}  // namespace limberg::fem
