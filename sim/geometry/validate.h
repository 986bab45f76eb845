#pragma once
// Whether a surface can be a body: closed, manifold, consistently oriented, in one part, around a positive volume,
// without degenerate triangles and without touching itself. Every decision is exact (integers of the rest grid).
#include <cstdint>
#include <span>
#include <string>

#include "sim/geometry/rest_grid.h"
#include "sim/geometry/tri_mesh.h"

namespace limberg {

struct SurfaceReport {
  int64_t vertices = 0, edges = 0, triangles = 0;  // vertices: those in use
  int genus = 0;
  double volume_mm3 = 0, area_mm2 = 0;
  bool turned = false;  // its triangles ran clockwise in its file (body/obj.h)
};

/// Throws InputError(file, line, ...) at the first offence, naming the triangle and where it is in mm.
/// `line_of_triangle` (may be empty) gives the line of the file that each triangle came from. Vertices must lie on the
/// even grid.
/// About 0.2 s for 60,000 triangles.
SurfaceReport validate_surface(const TriMesh& mesh, const RestGrid& grid, const std::string& file,
                               std::span<const int32_t> line_of_triangle = {});

}  // namespace limberg
