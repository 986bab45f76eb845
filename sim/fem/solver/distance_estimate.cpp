#include "sim/fem/solver/distance_estimate.h"

#include <algorithm>
#include <cmath>

namespace limberg::fem {
namespace {

constexpr double of_next = 0.7;

}  // namespace

void DistanceEstimate::forget(size_t nodes, std::span<const int32_t> aside) {
  known_ = 0;
  counts_.assign(nodes, 1);
  for (int32_t i : aside) counts_[size_t(i)] = 0;
}

double DistanceEstimate::largest_move(const NodeArray& a, const NodeArray& b) const {
  float most = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (!counts_[i]) continue;
    const float x = a[i].x - b[i].x, y = a[i].y - b[i].y, z = a[i].z - b[i].z;
    most = std::max(most, x * x + y * y + z * z);
  }
  return std::sqrt(double(most));
}

void DistanceEstimate::begin(const NodeArray& u) {
  if (known_ > 0 && past_[0].size() == u.size()) return;
  past_[0] = u, known_ = 1, since_ = 0;
}

void DistanceEstimate::moved(const NodeArray& u) {
  if (++since_ < every_) return;
  past_[2].swap(past_[1]), past_[1].swap(past_[0]), past_[0] = u;
  known_ = std::min(known_ + 1, int(past_.size())), since_ = 0;
}

double DistanceEstimate::operator()(const NodeArray& u, double next) const {
  if (known_ == 0) return of_next * next;
  double moved = largest_move(u, past_[size_t(known_ - 1)]);
  if (known_ == 3) {  // moves that shrink fast have little behind them
    const double later = largest_move(u, past_[1]), earlier = largest_move(past_[1], past_[2]);
    if (2 * later < earlier) moved *= 4 * later * later / (earlier * earlier);
  }
  return of_next * next + moved;
}

}  // namespace limberg::fem
