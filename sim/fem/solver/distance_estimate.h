#pragma once
// How far the tissue is from where it would come to rest, while the minimiser is still on its way.
//
// Two lengths are at hand in every step. One is the next move d that the minimiser would make (largest node) if every
// cell had the pressure that its volume asks for, p = lambda theta: where cells are nearly incompressible, multipliers
// that have not arrived hide most of the way. The other is the move m over the last ten to fourteen iterations. The
// metric is stiffer than the tissue in its soft modes, so d alone is too short; m alone says nothing of what has only
// begun. 0.7 d + m, with less of m where moves shrink fast, was the best of some sixty sums, means and rates on
// 2026-11-24, over frames after hooks, cuts, undermining and stitches with and without contact, fibres and divided
// fronts, Poisson's ratios of .45 to .499 (`limberg bench verification --only live` measures it anew). Where two moves
// in a row go the same way, as where contacts hold the tissue that the metric does not know, m is no less than the
// geometric series that they begin, at a ratio of .85 at most. It leans to the safe side. A flap that hangs on an edge
// is seen only when it slips. In slivers, cells a fifth full at most that hang on fuller ones, d is that of the
// pressure that is there: in one of .017 of a cell of .6 mm, .004 mm^3, a pressure that never arrived asked for moves
// of .2 mm (2026-11-26). In a dynamic step: the distance to the solution of that step.
#include <array>

#include "sim/base/simd.h"

namespace limberg::fem {

class DistanceEstimate {
 public:
  /// The unknowns are others now, or were set from outside: what went before says nothing.
  void forget() { known_ = 0; }
  /// Before the iterations of a step.
  void begin(const NodeArray& u);
  /// After an accepted iterate.
  void moved(const NodeArray& u);
  /// u: the present state; next_mm: d there.
  double operator()(const NodeArray& u, double next_mm) const;

 private:
  static constexpr int every_ = 5;
  std::array<NodeArray, 3> past_;  // the newest first
  int known_ = 0;                  // of them
  int since_ = 0;                  // iterates since the newest
};

}  // namespace limberg::fem
