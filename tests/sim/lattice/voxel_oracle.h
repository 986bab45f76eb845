#pragma once
// Connected pieces of the material in a cell by flood fill over n^3 sample points: an oracle that shares nothing with
// the code under test. It errs both ways for pieces or necks thinner than a voxel.
#include <algorithm>
#include <vector>

#include "sim/cutting/arrangement/arrangement.h"
#include "sim/lattice/lattice.h"

namespace limberg::test {

class VoxelOracle {
 public:
  explicit VoxelOracle(const Arrangement& a) : a_(a) {
    for (size_t f = 0; f < a.faces().size(); ++f) {
      const Face& face = a.faces()[f];
      if (!face.live()) continue;
      Triangle t;
      for (size_t k = 0; k < 3; ++k) t.p[k] = a.point_mm(face.v[k]);
      t.mat = face.mat;
      tri_.push_back(t);
    }
  }

  /// Fractions of the cell filled by each piece, descending.
  std::vector<double> pieces(const LatticeGrid& g, int32_t cell, int n) const {
    const Vec3 low = g.node_mm(g.cell_at(cell)), h = g.cell_mm();
    const auto at = [&](int i, int axis) { return low[axis] + h[axis] * (i + 0.5) / n; };
    const auto id = [&](int i, int j, int k) { return (size_t(k) * size_t(n) + size_t(j)) * size_t(n) + size_t(i); };
    std::vector<uint8_t> in(size_t(n) * size_t(n) * size_t(n), 0);
    std::vector<uint8_t> wall(in.size(), 0);  // bit axis: something lies between this sample and the next along it
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      std::vector<Triangle> near;
      for (const Triangle& t : tri_) {
        const Vec3 lo = t.p[0].cwiseMin(t.p[1]).cwiseMin(t.p[2]), hi = t.p[0].cwiseMax(t.p[1]).cwiseMax(t.p[2]);
        if (hi[u] >= low[u] && lo[u] <= low[u] + h[u] && hi[v] >= low[v] && lo[v] <= low[v] + h[v]) near.push_back(t);
      }
      std::vector<std::pair<double, uint8_t>> hits;
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const double cu = at(i, u), cv = at(j, v);
          hits.clear();
          for (const Triangle& t : near) {
            double w[3], sum = 0;
            for (size_t k = 0; k < 3; ++k) {
              const Vec3 &p = t.p[(k + 1) % 3], &q = t.p[(k + 2) % 3];
              sum += w[k] = (p[u] - cu) * (q[v] - cv) - (p[v] - cv) * (q[u] - cu);
            }
            if (!((w[0] > 0 && w[1] > 0 && w[2] > 0) || (w[0] < 0 && w[1] < 0 && w[2] < 0))) continue;
            const double x = (w[0] * t.p[0][axis] + w[1] * t.p[1][axis] + w[2] * t.p[2][axis]) / sum;
            hits.push_back({x, uint8_t(sum > 0 ? t.mat & 1 : t.mat >> 1 & 1)});  // material after the hit
          }
          std::sort(hits.begin(), hits.end());
          size_t next = 0;
          uint8_t state = 0;
          for (int k = 0; k < n; ++k) {
            bool crossed = false;
            for (; next < hits.size() && hits[next].first < at(k, axis); ++next)
              state = hits[next].second, crossed = true;
            int c[3];
            c[axis] = k, c[u] = i, c[v] = j;
            const size_t here = id(c[0], c[1], c[2]);
            if (axis == 0) in[here] = state;
            if (crossed && k > 0) {
              c[axis] = k - 1;
              wall[id(c[0], c[1], c[2])] |= uint8_t(1u << axis);
            }
          }
        }
    }
    std::vector<double> out;
    std::vector<size_t> stack;
    const size_t stride[3] = {1, size_t(n), size_t(n) * size_t(n)};
    for (size_t s = 0; s < in.size(); ++s) {
      if (!in[s]) continue;
      size_t count = 0;
      stack.assign(1, s);
      in[s] = 0;
      while (!stack.empty()) {
        const size_t v = stack.back();
        stack.pop_back();
        ++count;
        const size_t c[3] = {v % size_t(n), v / size_t(n) % size_t(n), v / stride[2]};
        for (size_t a = 0; a < 3; ++a) {
          if (c[a] + 1 < size_t(n) && !(wall[v] >> a & 1) && in[v + stride[a]])
            in[v + stride[a]] = 0, stack.push_back(v + stride[a]);
          if (c[a] > 0 && !(wall[v - stride[a]] >> a & 1) && in[v - stride[a]])
            in[v - stride[a]] = 0, stack.push_back(v - stride[a]);
        }
      }
      out.push_back(double(count) / double(in.size()));
    }
    std::sort(out.rbegin(), out.rend());
    return out;
  }

 private:
  struct Triangle {
    std::array<Vec3, 3> p;
    uint8_t mat = 0;
  };
  const Arrangement& a_;
  std::vector<Triangle> tri_;
};

}  // namespace limberg::test
