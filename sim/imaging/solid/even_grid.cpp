#include "sim/imaging/solid/even_grid.h"

#include <algorithm>
#include <cmath>

namespace limberg::imaging {

VoxelBox voxel_box(const Volume& v) {
  VoxelBox b;
  Mat3& Q = b.axes;
  Q.col(0) = v.step_mm.col(0).normalized();
  Q.col(1) = (v.step_mm.col(1) - Q.col(0) * Q.col(0).dot(v.step_mm.col(1))).normalized();
  Q.col(2) = Q.col(0).cross(Q.col(1));
  if (Q.col(2).dot(v.step_mm.col(2)) < 0) Q.col(2) = -Q.col(2);
  b.low = Vec3::Constant(1e300), b.high = -b.low;
  for (int c = 0; c < 8; ++c) {
    const Vec3 corner((c & 1) * (v.size[0] - 1), (c >> 1 & 1) * (v.size[1] - 1), (c >> 2) * (v.size[2] - 1));
    const Vec3 x = Q.transpose() * v.place(corner);
    b.low = b.low.cwiseMin(x), b.high = b.high.cwiseMax(x);
  }
  return b;
}

EvenGrid even_grid(const Volume& v, double h, int32_t pad, int64_t most_nodes) {
  const VoxelBox box = voxel_box(v);
  const Vec3 span = box.high - box.low;
  const auto count = [&](double step) {
    double all = 1;
    for (int k = 0; k < 3; ++k) all *= span[k] / step + 1 + 2 * pad;
    return all;
  };
  while (count(h) > double(most_nodes)) h *= 1.02;
  EvenGrid g;
  g.step_mm = h;
  for (size_t k = 0; k < 3; ++k) {
    const int32_t inner = int32_t(std::floor(span[Eigen::Index(k)] / h + 1e-9)) + 1;
    g.first[k] = pad, g.last[k] = pad + inner - 1, g.nodes.size[k] = inner + 2 * pad;
  }
  g.nodes.step_mm = h * box.axes, g.nodes.origin_mm = box.axes * (box.low - Vec3::Constant(pad * h));
  return g;
}

std::vector<float> sampled(const Volume& v, const EvenGrid& g, float beyond, Workers& workers) {
  const GridSize& n = g.nodes.size;
  std::vector<float> out(nodes(n), beyond);
  const VolumeSampler sampler(v);
  workers.parallel_for(size_t(n[2]), 1, [&](size_t k0, size_t k1) {
    for (int32_t k = std::max(g.first[2], int32_t(k0)); k < std::min(g.last[2] + 1, int32_t(k1)); ++k)
      for (int32_t j = g.first[1]; j <= g.last[1]; ++j)
        for (int32_t i = g.first[0]; i <= g.last[0]; ++i)
          out[g.nodes.index(i, j, k)] = float(sampler.value(g.nodes.place(Vec3(i, j, k))));
  });
  return out;
}

GridParts parts_of(const GridSize& n, const std::vector<uint8_t>& set) {
  GridParts p;
  p.of.assign(set.size(), -1);
  std::vector<size_t> stack;
  for (size_t i = 0; i < set.size(); ++i) {
    if (!set[i] || p.of[i] >= 0) continue;
    const int32_t part = int32_t(p.nodes.size());
    p.nodes.push_back(1), p.of[i] = part, stack.assign(1, i);
    while (!stack.empty()) {
      const size_t v = stack.back();
      stack.pop_back();
      neighbours(n, v, [&](size_t j) {
        if (set[j] && p.of[j] < 0) p.of[j] = part, ++p.nodes.back(), stack.push_back(j);
      });
    }
  }
  return p;
}

}  // namespace limberg::imaging
