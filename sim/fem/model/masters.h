#pragma once
// Which unknowns move a node, one node at a time (hanging_nodes.h does it for all).
#include "sim/fem/model/hanging_nodes.h"

namespace limberg::fem {

/// Itself with weight 1, or the masters of a hanging node.
class Masters {
 public:
  explicit Masters(const FemModel& m) : model_(m), at_(hanging_index(m)) {}
  bool hangs(int32_t v) const { return !at_.empty() && at_[size_t(v)] >= 0; }
  const HangingNode& of(int32_t v) const { return model_.hanging[size_t(at_[size_t(v)])]; }
  template <class F>
  void each(int32_t v, const F& f) const {
    if (!hangs(v)) return f(v, 1.0);
    const HangingNode& h = of(v);
    for (size_t k = 0; k < size_t(h.count); ++k) f(h.master[k], double(h.weight[k]));
  }

 private:
  const FemModel& model_;
  std::vector<int32_t> at_;
};

}  // namespace limberg::fem
