#pragma once
// Limited-memory BFGS (Nocedal & Wright, Numerical Optimization,
// algorithm 7.4) with a given metric as the initial inverse Hessian.
#include <functional>
#include <vector>

#include "sim/fem/solver/engine.h"

namespace limberg::fem {

class LbfgsHistory {
 public:
  void resize(size_t nodes, int pairs);  // forgets everything; room for pairs is made as they come
  void clear() { count_ = 0; }
  int count() const { return count_; }

  /// Scratch for the next pair: fill s = u_new - u and y = g_new - g, then push().
  NodeArray& next_s() { return sized(s_[size_t(head_)]); }
  NodeArray& next_y() { return sized(y_[size_t(head_)]); }
  /// Takes the pair in the scratch; refuses one without positive curvature.
  bool push(const Engine& engine);

  /// d = -H g. `metric(r, z)` applies the initial inverse Hessian. `scaled`: that one times gamma = s.y / y.metric(y)
  /// of the newest pair, at most 1 (equation 7.20 with the metric in place of the identity). Returns gamma; 1 without.
  double direction(const NodeArray& g, NodeArray& d, const std::function<void(const NodeArray&, NodeArray&)>& metric,
                   const Engine& engine, bool scaled = false);

 private:
  size_t index(int k) const { return size_t((head_ - 1 - k + 2 * capacity_) % capacity_); }  // k-th newest
  NodeArray& sized(NodeArray& a) const {
    if (a.size() != nodes_) a.resize(nodes_);
    return a;
  }
  size_t nodes_ = 0;
  int capacity_ = 0, count_ = 0, head_ = 0;
  std::vector<NodeArray> s_, y_;
  std::vector<double> rho_;
  NodeArray q_;
};

}  // namespace limberg::fem
