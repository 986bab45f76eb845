#pragma once
// A sparse Cholesky factor as float panels, and its triangular solves for three right-hand sides at once.
//
// For every supernode with diagonal block D and off-diagonal block L21 one dense panel M = [D^-1 ; -L21 D^-1] is stored.
//   forward:   Y[panel rows] += M b       (b = the supernode's part of the right-hand side)
//   backward:  y = M^T [y1 ; x2]
// No recurrence inside a panel, and one panel serves both passes, so the operator is exactly symmetric up to rounding.
// Rows are stored in blocks of 16, column after column inside a block.
#include <vector>

#include "sim/fem/simd.h"

namespace limberg::fem {

/// What is needed of a supernodal factor L (columns of each supernode dense, rows ascending).
struct SupernodalView {
  int32_t n = 0, supernodes = 0;
  const int32_t* super = nullptr;  // first column of each, supernodes + 1 entries
  const int32_t* rows_begin = nullptr;
  const int32_t* rows = nullptr;   // row indices, the diagonal block's first
  const int32_t* values_begin = nullptr;
  const double* values = nullptr;  // column-major
};

class PanelFactor {
 public:
  PanelFactor() = default;
  explicit PanelFactor(const SupernodalView& L);

  int32_t n() const { return n_; }
  size_t bytes() const { return values_.size() * sizeof(float) + rows_.size() * sizeof(int32_t); }
  /// y := (L L^T)^-1 y; y in elimination order, n nodes.
  void solve(Node4* y) const;

 private:
  struct Panel {
    int32_t first = 0, columns = 0, rows = 0;  // rows: all, the diagonal block's included
    int32_t rows_begin = 0;                    // of the off-diagonal rows, in rows_
    size_t values = 0;
  };
  int32_t n_ = 0;
  int32_t max_columns_ = 0, max_rows_ = 0;
  std::vector<Panel> panels_;
  std::vector<int32_t> rows_;
  AlignedArray<float> values_;
};

}  // namespace limberg::fem
