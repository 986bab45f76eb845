#pragma once
// How far the tissue is from where it would come to rest, while the minimiser is still on its way.
//
// Two lengths are at hand in every step: the next move that the minimiser would make, d = |H g| (largest
// node), and the move m over its last ten to twenty iterations. Iterates that shrink by a factor r each
// time are d / (1 - r) away; the next move alone is too short (the metric is stiffer than the tissue in
// its soft modes), the last moves alone too long. Their geometric mean was the best of eleven such
// estimates on 2026-11-21, over jumps of hooks and the actions of the shipped scripts: with the factor
// here nine of ten frames are within a factor of 3.3 of the truth (`limberg bench verification` measures
// it anew). It is an estimate, not a bound. In a dynamic step: the distance to the solution of that step.
#include "sim/base/simd.h"

namespace limberg::fem {

class DistanceEstimate {
 public:
  /// The unknowns are others now, or were set from outside: what went before says nothing.
  void forget() { count_ = -1; }
  /// After an accepted iterate.
  void moved(const NodeArray& u);
  /// u: the present state; next_mm: |H g| there.
  double operator()(const NodeArray& u, double next_mm) const;

 private:
  static constexpr int every_ = 10;
  NodeArray older_, newer_;
  int count_ = -1;  // iterates since newer_; -1: nothing is known
  bool has_older_ = false;
};

}  // namespace limberg::fem
