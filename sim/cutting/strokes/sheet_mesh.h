#pragma once
// A regular triangle mesh of a polygon in the plane: floors of plugs and undermining sheets.
#include <optional>
#include <span>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct PlaneMesh {
  std::vector<Vec2> vertex;  // the polygon's own vertices first, in order
  std::vector<Tri> tri;      // counter-clockwise
};

/// Constrained Delaunay triangulation of a simple counter-clockwise polygon with an interior triangular grid. The
/// polygon's edges stay edges (resample them first). Empty when the polygon meets itself.
std::optional<PlaneMesh> mesh_polygon(std::span<const Vec2> polygon, double spacing);

}  // namespace limberg
