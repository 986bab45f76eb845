#pragma once
// Blade surfaces: what a scalpel sweeps, in rest space, on the even grid.
//
// A blade is an embedded (non-self-intersecting) triangle strip or sheet. Seeds say which of its triangles the surgeon
// really drew: only patches of the blade that lie in material and hold a seed become walls; extensions and overshoot
// are never seeds (cutting-order rules: see arrangement.h).
#include <cstdint>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct Blade {
  std::vector<Int3> vertex;           // even grid coordinates
  std::vector<int32_t> shared_point;  // per vertex: id of an existing explicit arrangement point to reuse, or -1
  std::vector<Tri> tri;
  std::vector<uint8_t> seed;          // per triangle, 1 = drawn
  std::vector<std::array<Eigen::Vector2f, 3>> uv_mm;  // per corner: (arc length, depth), for the wall's texture
};

}  // namespace limberg
