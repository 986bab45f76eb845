#pragma once
// The smooth parts of a wounded surface, found once, at rest.
//
// A sheet is what hangs together over edges that turn by less than 40 degrees, wall with wall and skin with skin: one
// bank of an incision, the roof of a pocket, the skin beside a rim. What presses on a place presses sheet by sheet, so
// a place in a corner can be held by two. Within a sheet the normal is made to turn smoothly: a corner's normal is the
// sum of the area vectors of its triangles in that sheet (its fan), and between corners it goes linearly.
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct Sheets {
  std::vector<int32_t> of;  // sheet per triangle, numbered by their first triangles
  std::vector<Tri> fan;     // fan per triangle and corner
  std::vector<int32_t> fan_begin,
      fan_triangle;  // triangles of fan f: fan_triangle[fan_begin[f]] ... [fan_begin[f + 1]]
  std::vector<std::pair<int32_t, int32_t>> meet;  // sheets that share an edge, lower number first; sorted
  int32_t count = 0;

  bool adjacent(int32_t a, int32_t b) const;
  std::span<const int32_t> triangles_of_fan(int32_t f) const {
    return {fan_triangle.data() + fan_begin[size_t(f)], size_t(fan_begin[size_t(f) + 1] - fan_begin[size_t(f)])};
  }
};

/// `around_begin`, `around`: triangles around each vertex, ascending; `kind` per triangle: sheets never mix them.
Sheets find_sheets(std::span<const Vec3> X_mm, std::span<const Tri> tri, std::span<const uint8_t> kind,
                   std::span<const int32_t> around_begin, std::span<const int32_t> around);

}  // namespace limberg
