#pragma once
// Sparse Cholesky of the scalar matrix, handed on as float panels: order by METIS or a given one, supernodes by
// CHOLMOD, numbers by supernodal.h.
#include <span>

#include "sim/base/workers.h"
#include "sim/fem/preconditioner/supernodal.h"

namespace limberg::fem {

struct ScalarFactor {
  PanelFactor panels;
  std::vector<int32_t> node_order;  // node of the model eliminated k-th
};

/// Nested dissection of the matrix's graph by METIS: rows in the order of elimination. The same matrix has the same
/// order whatever else is at work, if the workers' alone() keeps others out.
std::vector<int32_t> nested_dissection(const ScalarMatrix& A, Workers& workers);

/// Which columns of the factor make a supernode, by CHOLMOD's analysis: whole numbers only. `order`: rows in
/// elimination order, as many as the matrix has.
SupernodalShape analyze(const ScalarMatrix& A, std::span<const int32_t> order);

/// Throws std::runtime_error if the matrix is not positive definite. `order`: rows in elimination order.
ScalarFactor factorize(const ScalarMatrix& A, std::span<const int32_t> order);

/// In METIS's order.
inline ScalarFactor factorize(const ScalarMatrix& A, Workers& workers) {
  return factorize(A, nested_dissection(A, workers));
}

}  // namespace limberg::fem
