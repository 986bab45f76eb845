#include "sim/fem/solver/distance_estimate.h"

#include <algorithm>
#include <cmath>

namespace limberg::fem {
namespace {

constexpr double scale = 0.9;  // of sqrt(d m)
constexpr double alone = 4.4;  // of d, when nothing else is known: the median of truth / d was 4.4

double largest_move(const NodeArray& a, const NodeArray& b) {
  float most = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const float x = a[i].x - b[i].x, y = a[i].y - b[i].y, z = a[i].z - b[i].z;
    most = std::max(most, x * x + y * y + z * z);
  }
  return std::sqrt(double(most));
}

}  // namespace

void DistanceEstimate::moved(const NodeArray& u) {
  if (count_ < 0 || newer_.size() != u.size()) {
    newer_ = u, count_ = 0, has_older_ = false;
  } else if (++count_ == every_) {
    older_.swap(newer_), newer_ = u, count_ = 0, has_older_ = true;
  }
}

double DistanceEstimate::operator()(const NodeArray& u, double next) const {
  const bool known = count_ >= 0 && newer_.size() == u.size() && (has_older_ || count_ >= every_ / 2);
  if (!known) return alone * next;
  const double m = largest_move(u, has_older_ ? older_ : newer_);
  // The truth is hardly ever beyond either of these.
  return std::clamp(scale * std::sqrt(next * m), next, 30 * next);
}

}  // namespace limberg::fem
