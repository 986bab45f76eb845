#include "sim/fem/solver/distance_estimate.h"

#include <algorithm>
#include <cmath>

namespace limberg::fem {
namespace {

constexpr double of_next = 0.7;
// A slow approach: two moves in a row go the same way, and the later is at most so much of the earlier. Then a
// geometric series is still to come.
constexpr double same_way = 0.3, slowest = 0.85;

double largest_move(const NodeArray& a, const NodeArray& b) {
  float most = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const float x = a[i].x - b[i].x, y = a[i].y - b[i].y, z = a[i].z - b[i].z;
    most = std::max(most, x * x + y * y + z * z);
  }
  return std::sqrt(double(most));
}

/// How much of `earlier` = b - a is left in `later` = c - b, along it; 0 where they do not go the same way.
double ratio_of_moves(const NodeArray& a, const NodeArray& b, const NodeArray& c) {
  double both = 0, of_earlier = 0, of_later = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const v4 e = load(b[i]) - load(a[i]), l = load(c[i]) - load(b[i]);
    both += double(e[0] * l[0] + e[1] * l[1] + e[2] * l[2]);
    of_earlier += double(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
    of_later += double(l[0] * l[0] + l[1] * l[1] + l[2] * l[2]);
  }
  return both > same_way * std::sqrt(of_earlier * of_later) ? both / of_earlier : 0;
}

}  // namespace

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
    const double ratio = std::min(ratio_of_moves(past_[2], past_[1], u), slowest);
    moved = std::max(moved, later * ratio / (1 - ratio));
  }
  return of_next * next + moved;
}

}  // namespace limberg::fem
