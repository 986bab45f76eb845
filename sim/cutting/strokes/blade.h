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
  // Per triangle. 0: extension. 1: drawn on the skin; a seed for the patch in which it crosses the body's own surface.
  // 2: drawn within the body (sheet, plug); a seed for every patch that has a part of it.
  // 3: goes on where an earlier wall ends; a seed for the patch that touches that end (a shared edge).
  std::vector<uint8_t> seed;
  std::vector<std::array<Eigen::Vector2f, 3>> uv_mm;  // per corner: (arc length, depth), for the wall's texture
  // columns from the skin down; uv_mm are (place along the stroke, level). Later strokes can go on.
  bool strip = false;
};

}  // namespace limberg
