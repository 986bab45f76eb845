#include "devices/bone_contour.h"

#include <cmath>

namespace limberg {

namespace {

/// Places every `step` along the closed line.
std::vector<Vec3> evenly(const std::vector<Vec3>& p, double step) {
  double length = 0;
  for (size_t i = 0; i < p.size(); ++i) length += (p[(i + 1) % p.size()] - p[i]).norm();
  const auto n = size_t(std::max(3.0, std::floor(length / step)));
  std::vector<Vec3> out;
  double passed = 0;
  for (size_t i = 0; i < p.size() && out.size() < n; ++i) {
    const Vec3 &a = p[i], &b = p[(i + 1) % p.size()];
    const double edge = (b - a).norm();
    while (out.size() < n && double(out.size()) * length / double(n) <= passed + edge) {
      const double t = edge > 0 ? (double(out.size()) * length / double(n) - passed) / edge : 0;
      out.push_back(a + t * (b - a));
    }
    passed += edge;
  }
  return out;
}

}  // namespace

std::vector<Vec3> bone_contour(const std::vector<Vec3>& drawn, const BoneContourSettings& set) {
  std::vector<double> at{0};
  for (size_t i = 1; i < drawn.size(); ++i) at.push_back(at.back() + (drawn[i] - drawn[i - 1]).norm());
  if (drawn.size() < 4 || at.back() < set.least_mm) return {};
  // The end: of the last third, what lies nearest to the beginning.
  size_t end = drawn.size() - 1;
  for (size_t i = drawn.size(); i-- > 0 && at[i] > at.back() * 2 / 3;)
    if ((drawn[i] - drawn[0]).norm() < (drawn[end] - drawn[0]).norm()) end = i;
  const std::vector<Vec3> fine =
      evenly(std::vector<Vec3>(drawn.begin(), drawn.begin() + long(end) + 1), set.smooth_mm / 5);
  const auto n = long(fine.size());
  std::vector<Vec3> smooth(fine.size());
  for (long i = 0; i < n; ++i) {
    Vec3 sum = Vec3::Zero();
    double weights = 0;
    for (long k = -5; k <= 5; ++k) {
      const double w = 6 - double(std::abs(k));
      sum += w * fine[size_t(((i + k) % n + n) % n)];
      weights += w;
    }
    smooth[size_t(i)] = sum / weights;
  }
  return evenly(smooth, set.step_mm);
}

}  // namespace limberg
