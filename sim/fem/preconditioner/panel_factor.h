#pragma once
// A sparse Cholesky factor as float panels, and its triangular solves for three right-hand sides at once.
//
// For every supernode with diagonal block D and off-diagonal
// block L21 one dense panel M = [D^-1 ; -L21 D^-1] is stored.
//   forward:   Y[panel rows] += M b       (b = the supernode's part of the right-hand side)
//   backward:  y = M^T [y1 ; x2]
// No recurrence inside a panel, and one panel serves both passes, so the operator is exactly symmetric up to rounding.
// Rows are stored in blocks of 16, column after column inside a block.
//
// Several threads: the tree of supernodes is cut into a few subtrees of about the same work and
// the rest, the top. Subtrees share no column, so each can be solved by a thread of its own; what
// a subtree adds to rows of the top it puts down in a log instead, in the order in which it would
// have been added. The top is walked on one thread, in the order of all panels, adding a subtree's
// log where the subtree would have stood: the same sums in the same order as on one thread.
#include <vector>

#include "sim/fem/solver/engine.h"

namespace limberg::fem {

/// What is needed of a supernodal factor L (columns of each supernode dense, rows ascending).
struct SupernodalView {
  int32_t n = 0, supernodes = 0;
  const int32_t* super = nullptr;  // first column of each, supernodes + 1 entries
  const int32_t* rows_begin = nullptr;
  const int32_t* rows = nullptr;         // row indices, the diagonal block's first
  const size_t* values_begin = nullptr;  // supernodes + 1 entries
  const double* values = nullptr;        // column-major, columns of `leading`(rows) numbers
  static size_t leading(size_t rows) { return (rows + leading_step - 1) / leading_step * leading_step; }
};

class PanelFactor {
 public:
  PanelFactor() = default;
  explicit PanelFactor(const SupernodalView& L);

  int32_t n() const { return n_; }
  size_t bytes() const { return values_.size() * sizeof(float) + rows_.size() * sizeof(int32_t); }
  /// y := (L L^T)^-1 y; y in elimination order, n nodes. Same bits for any number of workers.
  void solve(Node4* y, const Engine& engine) const;

 private:
  /// Panels [first, last): a subtree when its adds above go to `log`, or a stretch of the top.
  struct Stretch {
    int32_t first = 0, last = 0;
    bool subtree = false;
    size_t log = 0, log_length = 0;  // in nodes
  };
  void find_subtrees();
  void replay(const Stretch& s, Node4* y, const Node4* log) const;
  int32_t n_ = 0;
  int32_t max_columns_ = 0, max_rows_ = 0;
  std::vector<Panel> panels_;
  std::vector<Stretch> stretches_;  // all panels in order; one when there are too few to share
  std::vector<int32_t> subtrees_;   // of these, the largest first
  size_t log_length_ = 0;
  std::vector<int32_t> rows_;
  AlignedArray<float> values_;
};

}  // namespace limberg::fem
