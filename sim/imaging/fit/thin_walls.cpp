#include "sim/imaging/fit/thin_walls.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "sim/imaging/fit/prepare.h"

namespace limberg::imaging {

namespace {

constexpr double kFlat = 0.5;  // second curvature over the first: a sheet, no rod and no grain
// steps, along the axis that crosses it most: a crest passes through every node that is so near; without gaps
constexpr double kBeside = 0.75;

/// Whether the crest of a sheet passes by node i; `across`: its normal.
bool on_crest(const std::vector<float>& f, const GridSize& n, size_t i, Vec3& across) {
  const size_t s[3] = {1, size_t(n[0]), size_t(n[0]) * size_t(n[1])};
  const auto at = [&](size_t j) { return double(f[j]); };
  Vec3 g;
  Mat3 H;
  for (int a = 0; a < 3; ++a) {
    g[a] = 0.5 * (at(i + s[a]) - at(i - s[a]));
    H(a, a) = at(i + s[a]) - 2 * at(i) + at(i - s[a]);
    for (int b = 0; b < a; ++b)
      H(a, b) = H(b, a) =
          0.25 * (at(i + s[a] + s[b]) - at(i + s[a] - s[b]) - at(i - s[a] + s[b]) + at(i - s[a] - s[b]));
  }
  Eigen::SelfAdjointEigenSolver<Mat3> e;
  e.computeDirect(H);
  const Vec3& c = e.eigenvalues();  // rising
  if (!(c[0] < 0) || std::abs(c[1]) > -kFlat * c[0]) return false;
  across = e.eigenvectors().col(0);
  return std::abs(across.dot(g) / c[0]) * across.cwiseAbs().maxCoeff() <= kBeside;
}

}  // namespace

bool crest_passes(const Volume& blurred, size_t i, Vec3& across) {
  return on_crest(blurred.value, blurred.size, i, across);
}

std::vector<size_t> thin_walls(const Volume& values, const std::vector<uint8_t>& set, const std::vector<uint8_t>& may,
                               const WallRule& rule, Workers& workers) {
  const GridSize& n = values.size;
  const Volume blurred = smoothed(values, rule.blur, workers);
  const std::vector<float> far = squared_distance(n, set, workers);
  std::vector<uint8_t> crest(set.size(), 0);
  workers.parallel_for(set.size(), 4096, [&](size_t b, size_t e) {
    for (size_t i = b; i < e; ++i) {
      if (set[i] || !may[i] || !(double(values.value[i]) >= rule.above) || double(far[i]) > rule.across * rule.across)
        continue;
      const auto at = node_at(n, i);
      if (at[0] == 0 || at[1] == 0 || at[2] == 0 || at[0] + 1 == n[0] || at[1] + 1 == n[1] || at[2] + 1 == n[2])
        continue;
      Vec3 across;
      if (!on_crest(blurred.value, n, i, across)) continue;
      const auto beside = [&](double way) {
        std::array<int32_t, 3> to = at;
        for (int k = 0; k < 3; ++k)
          to[size_t(k)] = std::clamp(at[size_t(k)] + int32_t(std::lround(way * across[k])), 0, n[size_t(k)] - 1);
        return double(values.value[values.index(to[0], to[1], to[2])]);
      };
      crest[i] = std::max(beside(rule.beside), beside(-rule.beside)) > rule.air;
    }
  });
  std::vector<size_t> out;
  const auto reach = [&](size_t from) {
    all_around(n, from, [&](size_t j, int) {
      if (crest[j]) crest[j] = 0, out.push_back(j);
    });
  };
  for (size_t i = 0; i < set.size(); ++i)
    if (set[i] && double(far[i]) == 0) reach(i);
  for (size_t k = 0; k < out.size(); ++k) reach(out[k]);
  return out;
}

}  // namespace limberg::imaging
