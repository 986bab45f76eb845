#include "calibration/distortion.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace limberg {

DistortionResult calibrate_distortion(const std::vector<Vec3>& measured, const std::vector<Vec3>& known,
                                      const DistortionSettings& set) {
  DistortionResult r;
  if (measured.size() != known.size() || measured.size() < size_t(set.points)) {
    r.advice = fmt::format(
        "{} measured and {} known points where {} pairs are needed: touch a grid of known points all over the working "
        "space",
        measured.size(), known.size(), set.points);
    return r;
  }
  DistortionGrid& g = r.grid;
  const int n = std::clamp(set.nodes, 2, 12);
  g.nodes = {n, n, n};
  g.low_mm = g.high_mm = measured[0];
  for (const Vec3& p : measured) g.low_mm = g.low_mm.cwiseMin(p), g.high_mm = g.high_mm.cwiseMax(p);
  const Vec3 size = (g.high_mm - g.low_mm).cwiseMax(1.0);
  g.high_mm = g.low_mm + size;
  const int count = n * n * n;
  g.add_mm.assign(size_t(count), Vec3::Zero());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(count, count), b = Eigen::MatrixXd::Zero(count, 3);
  // The weights of a point's eight nodes, read off the grid's own interpolation.
  const auto weights = [&](const Vec3& p, int(&node)[8], double(&w)[8]) {
    int at[3];
    double f[3];
    for (int i = 0; i < 3; ++i) {
      const double s = std::clamp((p[i] - g.low_mm[i]) / size[i], 0.0, 1.0) * (n - 1);
      at[i] = std::min(int(s), n - 2), f[i] = s - at[i];
    }
    for (int k = 0; k < 8; ++k) {
      const int x = at[0] + (k & 1), y = at[1] + (k >> 1 & 1), z = at[2] + (k >> 2);
      node[k] = (z * n + y) * n + x;
      w[k] = (k & 1 ? f[0] : 1 - f[0]) * (k >> 1 & 1 ? f[1] : 1 - f[1]) * (k >> 2 ? f[2] : 1 - f[2]);
    }
  };
  const auto held_out = [](size_t i) { return i % 5 == 4; };
  for (size_t i = 0; i < measured.size(); ++i) {
    if (held_out(i)) continue;
    int node[8];
    double w[8];
    weights(measured[i], node, w);
    const Vec3 add = known[i] - measured[i];
    for (int k = 0; k < 8; ++k) {
      b.row(node[k]) += w[k] * add.transpose();
      for (int l = 0; l < 8; ++l) A(node[k], node[l]) += w[k] * w[l];
    }
  }
  const int step[3] = {1, n, n * n};
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (int axis = 0; axis < 3; ++axis) {
          const int place = axis == 0 ? x : axis == 1 ? y : z;
          if (place + 2 >= n) continue;
          const int first = (z * n + y) * n + x;
          const int at[3] = {first, first + step[axis], first + 2 * step[axis]};
          const double d[3] = {1, -2, 1};
          for (int k = 0; k < 3; ++k)
            for (int l = 0; l < 3; ++l) A(at[k], at[l]) += set.smoothing * d[k] * d[l];
        }
  A.diagonal().array() += 1e-9;  // nodes that nothing speaks for
  const Eigen::MatrixXd x = A.ldlt().solve(b);
  for (int i = 0; i < count; ++i) g.add_mm[size_t(i)] = x.row(i).transpose();
  double before = 0, after = 0, fitted = 0;
  int outs = 0, ins = 0;
  for (size_t i = 0; i < measured.size(); ++i) {
    const double left2 = (measured[i] + g.at(measured[i]) - known[i]).squaredNorm();
    if (held_out(i))
      before += (measured[i] - known[i]).squaredNorm(), after += left2, ++outs;
    else
      fitted += left2, ++ins;
  }
  r.before_mm = std::sqrt(before / outs), r.after_mm = std::sqrt(after / outs), r.fitted_mm = std::sqrt(fitted / ins);
  r.accepted = r.after_mm * set.gain <= r.before_mm;
  if (!r.accepted) {
    r.advice = fmt::format(
        "the error at points held out falls only from {:.2f} to {:.2f} mm where a factor of {:.1f} is needed: leave "
        "the correction out, or touch more points",
        r.before_mm, r.after_mm, set.gain);
  }
  return r;
}

}  // namespace limberg
