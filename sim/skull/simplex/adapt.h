#pragma once
// Refinement: long faces are split, short ones merged, and edges exchanged where that makes faces more like hexagons,
// until every face has about the area that is wanted there.
//
// Wanted area: that of a hexagon with edges of h = edge_mm; with a chord error, h is the length whose sagitta on the
// local mean curvature is that error, h^2 |H| / 8 = chord_mm, between min_edge_mm and edge_mm. Split above sqrt(2) of
// it (or above nine vertices, or where a face is twice as long as wide and larger than wanted), merged where the
// product of two neighbours is below a quarter of the squared wanted area: what a split leaves is never merged again.
// Locked vertices, kept contours and rims
// stay as the operators leave them.
#include <cstdint>
#include <functional>
#include <string>

#include "sim/skull/simplex/edit.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::simplex {

struct AdaptSettings {
  double edge_mm = 2;                          // wanted (largest) edge
  std::function<double(const Vec3&)> edge_at;  // the wanted edge by place, at most edge_mm; may be empty
  double chord_mm = 0;                         // > 0: allowed distance of an edge from the curved surface
  double min_edge_mm = 0;                      // with chord_mm: smallest wanted edge; 0: edge_mm / 8
  int passes = 6;                              // at most; stops when a pass changes nothing
  double most_per_pass = 0.25;                 // splits and merges in one pass, of the number of faces
  int32_t max_vertices = 2'000'000;
  uint64_t seed = 1;  // order in which faces are looked at
};

struct AdaptReport {
  int64_t splits = 0, merges = 0, exchanges = 0;
  int passes = 0;
  bool settled = false;  // the last pass changed nothing
};

/// Throws InputError on lengths that are not finite and positive. What it did is appended to `delta`.
AdaptReport adapt(Mesh& mesh, const AdaptSettings& settings, Delta& delta);

/// How good the faces are (end faces left out).
struct FaceQuality {
  int32_t smallest = 0, largest = 0;  // vertices of a face
  double mean_deviation = 0;          // mean of |6 - vertices|
  double area_cv = 0;                 // standard deviation of the areas over their mean
};
FaceQuality face_quality(const Mesh& mesh);

}  // namespace limberg::simplex
