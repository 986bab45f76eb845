#include "sim/geometry/point_tree.h"

#include <algorithm>
#include <cmath>

namespace limberg {

PointTree::PointTree(std::span<const Vec3> points)
    : x_(points.begin(), points.end()), order_(points.size()), axis_(points.size(), 0) {
  for (size_t i = 0; i < order_.size(); ++i) order_[i] = int32_t(i);
  build(0, order_.size());
}

void PointTree::build(size_t begin, size_t end) {
  if (end - begin < 2) return;
  Vec3 lo = x_[size_t(order_[begin])], hi = lo;
  for (size_t i = begin; i < end; ++i) lo = lo.cwiseMin(x_[size_t(order_[i])]), hi = hi.cwiseMax(x_[size_t(order_[i])]);
  int axis = 0;
  (hi - lo).maxCoeff(&axis);
  const size_t middle = (begin + end) / 2;
  std::nth_element(order_.begin() + ptrdiff_t(begin), order_.begin() + ptrdiff_t(middle),
                   order_.begin() + ptrdiff_t(end), [&](int32_t a, int32_t b) {
                     const double p = x_[size_t(a)][axis], q = x_[size_t(b)][axis];
                     return p != q ? p < q : a < b;
                   });
  axis_[middle] = uint8_t(axis);
  build(begin, middle);
  build(middle + 1, end);
}

template <class Visit>
void PointTree::walk(const Vec3& p, size_t begin, size_t end, double& radius2, Visit&& visit) const {
  if (begin >= end) return;
  const size_t middle = (begin + end) / 2;
  const int32_t i = order_[middle];
  visit(i, (x_[size_t(i)] - p).squaredNorm());
  const double d = p[axis_[middle]] - x_[size_t(i)][axis_[middle]];
  const bool left = d < 0;
  walk(p, left ? begin : middle + 1, left ? middle : end, radius2, visit);
  if (d * d <= radius2) walk(p, left ? middle + 1 : begin, left ? end : middle, radius2, visit);
}

PointTree::Nearest PointTree::nearest(const Vec3& p, double most) const {
  Nearest best;
  double r2 = std::isfinite(most) ? most * most : most;
  walk(p, 0, order_.size(), r2, [&](int32_t i, double d2) {
    if (d2 < r2 || (d2 == r2 && (best.index < 0 || i < best.index))) r2 = d2, best.index = i;
  });
  if (best.index >= 0) best.distance = std::sqrt(r2);
  return best;
}

void PointTree::nearest(const Vec3& p, size_t count, std::vector<Nearest>& out) const {
  out.clear();
  if (count == 0) return;
  double r2 = std::numeric_limits<double>::infinity();
  const auto before = [](const Nearest& a, const Nearest& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.index < b.index;
  };
  walk(p, 0, order_.size(), r2, [&](int32_t i, double d2) {
    const Nearest n{i, d2};
    if (out.size() == count && !before(n, out.back())) return;
    if (out.size() == count) out.pop_back();
    out.insert(std::upper_bound(out.begin(), out.end(), n, before), n);
    if (out.size() == count) r2 = out.back().distance;
  });
  for (Nearest& n : out) n.distance = std::sqrt(n.distance);
}

}  // namespace limberg
