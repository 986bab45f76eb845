#pragma once
// Where the metric is far too soft, and what it lacks there.
//
// The metric is the stiffness at rest (scalar_matrix.h). A cell that is drawn out and keeps its volume resists far more
// along the direction N in which it has become thin: the volumetric part of its Hessian, traced over x, y and z, is
//
//   scale ke V B_a . adj(C) B_b,   adj(C) = cof F^T cof F,  C = F^T F,
//
// of which the metric holds the part at rest, adj(C) = I. At a stitch close to a
// wound's end, where cells are divided, stretches of 6.6 are met: along N, thin
// by 0.11, the eigenvalue is 87. The history holds the stiffest eight directions
// or so; with more of them the minimiser goes astray (shipped rhomboid with
// divided fronts: residual 1e-2 after 2000 iterations, cells inside out).
//
// So each such direction enters the metric as a spring does: weights B_a . N on the cell's corners, stiffness
// what is lacking. The metric folds them in or adds them by the Woodbury identity (preconditioner.h). They are
// found anew when they are too far off, and leave when none is left. A single one is the history's business.
#include <span>
#include <vector>

#include "sim/fem/model/fem_model.h"
#include "sim/fem/preconditioner/scalar_matrix.h"
#include "sim/fem/solver/engine.h"

namespace limberg::fem {

class StretchedCells {
 public:
  /// Looks at all cells at displacement u. True when what the metric should have is not what it was.
  bool follow(const FemModel& model, const NodeArray& u, bool augmented, const Engine& engine);
  std::span<const SpringRow> rows() const { return rows_; }
  void clear() { found_.clear(), rows_.clear(); }

 private:
  struct Direction {
    int32_t cell = 0;
    double lacking = 0;  // of stiffness, mN mm: scale ke V (eigenvalue - 1)
    double times = 0;    // that, over what the metric has there at rest
    Vec3 N = Vec3::Zero();
  };
  bool enough(std::span<const Direction> now) const;

  std::vector<Direction> found_;  // by cell
  std::vector<SpringRow> rows_;   // of found_
  int32_t next_id_ = -1;          // springs' own are positive
};

}  // namespace limberg::fem
