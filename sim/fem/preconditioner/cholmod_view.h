#pragma once
// A matrix as CHOLMOD sees it. Included by .cpp files alone.
#include <cholmod.h>

#include "sim/fem/preconditioner/scalar_matrix.h"

namespace limberg::fem {

/// The lower triangle as CHOLMOD sees it; shares A's arrays.
inline cholmod_sparse cholmod_view(const ScalarMatrix& A) {
  cholmod_sparse S{};
  S.nrow = S.ncol = size_t(A.n());
  S.nzmax = A.row.size();
  S.p = const_cast<int32_t*>(A.begin.data());
  S.i = const_cast<int32_t*>(A.row.data());
  S.x = const_cast<double*>(A.value.data());
  S.stype = -1;
  S.itype = CHOLMOD_INT, S.xtype = CHOLMOD_REAL, S.dtype = CHOLMOD_DOUBLE;
  S.sorted = 1, S.packed = 1;
  return S;
}

}  // namespace limberg::fem
