#include "sim/fem/solver/lbfgs.h"

#include <algorithm>
#include <cmath>

namespace limberg::fem {

// One slot more than pairs in use, so that filling the scratch never spoils the oldest pair.
void LbfgsHistory::resize(size_t nodes, int pairs) {
  capacity_ = pairs + 1;
  nodes_ = nodes;
  s_.resize(size_t(capacity_));
  y_.resize(size_t(capacity_));
  rho_.assign(size_t(capacity_), 0);
  q_.resize(nodes);
  count_ = head_ = 0;
}

bool LbfgsHistory::push(const Engine& engine) {
  const double sy = engine.dot(next_s(), next_y());
  const double ss = engine.dot(next_s(), next_s()), yy = engine.dot(next_y(), next_y());
  if (!(sy > 1e-7 * std::sqrt(ss) * std::sqrt(yy)) || !std::isfinite(sy)) return false;
  rho_[size_t(head_)] = 1 / sy;
  head_ = (head_ + 1) % capacity_;
  if (count_ < capacity_ - 1) ++count_;
  return true;
}

double LbfgsHistory::direction(const NodeArray& g, NodeArray& d,
                               const std::function<void(const NodeArray&, NodeArray&)>& metric, const Engine& engine,
                               bool scaled) {
  if (count_ == 0) {
    q_.zero();
    engine.add_scaled(q_, -1, g);
    metric(q_, d);
    return 1;
  }
  std::vector<double> alpha(static_cast<size_t>(count_));
  // q = -g fused with the first product.
  q_.zero();
  double product = engine.add_scaled_dot(q_, -1, g, s_[index(0)]);
  for (int k = 0; k < count_; ++k) {
    const size_t i = index(k);
    alpha[size_t(k)] = rho_[i] * product;
    if (k + 1 < count_)
      product = engine.add_scaled_dot(q_, -alpha[size_t(k)], y_[i], s_[index(k + 1)]);
    else
      engine.add_scaled(q_, -alpha[size_t(k)], y_[i]);
  }
  double gamma = 1;
  if (scaled) {
    const NodeArray& y = y_[index(0)];
    metric(y, d);
    gamma = std::clamp(1 / (rho_[index(0)] * engine.dot(y, d)), 1e-6, 1.0);
    engine.add_scaled(q_, gamma - 1, q_);
  }
  metric(q_, d);
  product = engine.dot(y_[index(count_ - 1)], d);
  for (int k = count_; k-- > 0;) {
    const size_t i = index(k);
    const double c = alpha[size_t(k)] - rho_[i] * product;
    if (k > 0)
      product = engine.add_scaled_dot(d, c, s_[i], y_[index(k - 1)]);
    else
      engine.add_scaled(d, c, s_[i]);
  }
  return gamma;
}

}  // namespace limberg::fem
