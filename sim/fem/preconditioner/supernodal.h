#pragma once
// The numbers of a supernodal Cholesky factor, left-looking: L L^T = P A P^T (Ng and Peyton 1993, "Block sparse
// Cholesky algorithms on advanced uniprocessor computers"). Which columns make a supernode, and its rows, come from
// CHOLMOD's analysis; the numbers do not, since a BLAS sums in an order of its own for every processor.
#include <span>

#include "sim/fem/preconditioner/panel_factor.h"
#include "sim/fem/preconditioner/scalar_matrix.h"

namespace limberg::fem {

/// Columns of supernode s: [super[s], super[s + 1]); its rows, ascending, the columns' own first.
struct SupernodalShape {
  std::vector<int32_t> order;  // row of A eliminated k-th
  std::vector<int32_t> super, rows_begin, rows;
  int32_t supernodes() const { return int32_t(super.size()) - 1; }
};

struct SupernodalFactor {
  std::vector<size_t> begin;    // of every supernode's block in `values`
  AlignedArray<double> values;  // SupernodalView has the layout
};

/// Throws std::runtime_error if A is not positive definite. The same bits for every table of kernels.
SupernodalFactor factorize(const ScalarMatrix& A, const SupernodalShape& shape, const Kernels& kernels);

}  // namespace limberg::fem
