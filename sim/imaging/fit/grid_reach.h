#pragma once
// Parts of the preparation (prepare.h): an even grid of nodes, and what a ball reaches on it.
#include <array>
#include <cstdint>
#include <vector>

#include "sim/base/workers.h"

namespace limberg::imaging {

using GridSize = std::array<int32_t, 3>;

inline size_t nodes(const GridSize& n) { return size_t(n[0]) * size_t(n[1]) * size_t(n[2]); }

inline std::array<int32_t, 3> node_at(const GridSize& n, size_t i) {
  return {int32_t(i % size_t(n[0])), int32_t(i / size_t(n[0]) % size_t(n[1])),
          int32_t(i / (size_t(n[0]) * size_t(n[1])))};
}

/// Calls visit(node) for the up to six neighbours of node i.
template <class Visit>
void neighbours(const GridSize& n, size_t i, Visit&& visit) {
  const int64_t stride[3] = {1, n[0], int64_t(n[0]) * n[1]};
  const std::array<int32_t, 3> at = node_at(n, i);
  for (int k = 0; k < 3; ++k)
    for (int s : {-1, 1})
      if (at[size_t(k)] + s >= 0 && at[size_t(k)] + s < n[size_t(k)]) visit(size_t(int64_t(i) + s * stride[k]));
}

/// Calls visit(node, steps along axes 1..3) for the up to 26 nodes around node i.
template <class Visit>
void all_around(const GridSize& n, size_t i, Visit&& visit) {
  const std::array<int32_t, 3> at = node_at(n, i);
  for (int32_t c = -1; c <= 1; ++c)
    for (int32_t b = -1; b <= 1; ++b)
      for (int32_t a = -1; a <= 1; ++a) {
        const int32_t x = at[0] + a, y = at[1] + b, z = at[2] + c;
        if ((a == 0 && b == 0 && c == 0) || x < 0 || y < 0 || z < 0 || x >= n[0] || y >= n[1] || z >= n[2]) continue;
        visit(size_t(x) + size_t(n[0]) * (size_t(y) + size_t(n[1]) * size_t(z)),
              int(a != 0) + int(b != 0) + int(c != 0));
      }
}

/// What a ball of `radius` steps reaches from node 0 without touching what is set.
struct Reach {
  std::vector<float> to_set;      // squared distance of every node to what is set, in steps
  std::vector<float> to_centres;  // ... to the places of the ball's centre
  std::vector<uint8_t> centre;    // nodes that its centre reaches
  double radius = 0;
  /// The ball covers the node.
  bool air(size_t i) const { return double(to_centres[i]) < (radius > 0 ? (radius + 0.5) * (radius + 0.5) : 0.5); }
};
Reach reach(const GridSize& size, const std::vector<uint8_t>& set, double radius, Workers& workers);

}  // namespace limberg::imaging
