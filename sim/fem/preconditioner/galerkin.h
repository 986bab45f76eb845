#pragma once
// P^T A P row by row, and what of it a change of A and P leaves as it was.
//
// A coarse row is a function of the fine rows that its node interpolates and of the weights of their neighbours, summed
// in the order of the fine nodes; a row is copied only when all of these are the same under new names.
#include "sim/fem/preconditioner/coarsening.h"
#include "sim/fem/preconditioner/node_matrix.h"

namespace limberg::fem {

NodeMatrix galerkin(const NodeMatrix& A, const Coarsening& c);

/// The change of the coarse level that follows from a change of the fine one. False: nothing can be carried over.
bool compare_coarse(const Coarsening& before, const Coarsening& now, const NodeMatrix& A, const NodeChange& fine,
                    NodeChange& coarse);

/// The same bits as galerkin(A, c), with only the dirty rows computed.
NodeMatrix galerkin(const NodeMatrix& A, const Coarsening& c, const NodeMatrix& before, const NodeChange& coarse);

}  // namespace limberg::fem
