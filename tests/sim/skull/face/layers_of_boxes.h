#pragma once
// Tissue in layers of equal boxes, of which everything is known in closed form.
#include <array>
#include <utility>

#include "sim/skull/simplex/tissue.h"

namespace limberg::simplex::test {

/// nx x ny boxes of `edge_mm` in each layer of `height_mm`, six tetrahedra a box, layer by layer from z = 0; the corner
/// of the first box lies at x and y of `origin_mm`.
inline Tissue layers_of_boxes(int nx, int ny, int layers, double edge_mm, double height_mm, const Vec2& origin_mm) {
  Tissue t;
  t.layers = layers;
  const auto node = [&](int i, int j, int k) { return int32_t(((ny + 1) * k + j) * (nx + 1) + i); };
  for (int k = 0; k <= layers; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        t.node_mm.push_back({origin_mm.x() + edge_mm * i, origin_mm.y() + edge_mm * j, height_mm * k});
  for (int k = 0; k < layers; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (const std::array<int, 3>& order :  // the six ways from one corner of a box to the opposite one
             {std::array{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}) {
          std::array<int, 3> at{i, j, k};
          std::array<int32_t, 4> tet{node(i, j, k), 0, 0, 0};
          for (size_t c = 0; c < 3; ++c) ++at[size_t(order[c])], tet[c + 1] = node(at[0], at[1], at[2]);
          const Vec3 o = t.node_mm[size_t(tet[0])];
          const auto edge = [&](size_t c) { return Vec3(t.node_mm[size_t(tet[c])] - o); };
          if (edge(1).cross(edge(2)).dot(edge(3)) < 0) std::swap(tet[2], tet[3]);
          t.tet.push_back(tet);
        }
  return t;
}

}  // namespace limberg::simplex::test
