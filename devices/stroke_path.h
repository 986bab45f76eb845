#pragma once
// From a hand-drawn stroke to the path that was meant: straight edges straight, corners where they were drawn, arcs
// round.
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct PathSettings {
  double tolerance_mm = 0.4;    // tremor is below this, a meant bend above
  double corner_deg = 20;       // a turn of at least this between two fitted edges is a corner
  double corner_move_mm = 1.0;  // a corner is moved to where its edges' lines meet, at most this far
  double min_edge_mm = 2.0;     // shorter edges are joined to their neighbours
  bool curves = true;           // false of recordings from before: every curve is a polygon
};

/// Open path: Douglas-Peucker at the tolerance, then each edge is fitted by a
/// line (total least squares over its points, ends left out) and each corner
/// put where the lines of its edges meet. Edges that go over into each other
/// as a curve does, and an edge that is an arc, become a smooth line
/// (drawn_curve.h), given by points within an eighth of the tolerance of it.
/// End points: the end's foot on its edge's line or tangent. Fewer than two
/// points after joining: returned as they are.
std::vector<Vec2> simplify_path(const std::vector<Vec2>& points, const PathSettings& settings = {});

/// The same for a closed outline; the first point is not repeated at the end. What runs on beyond its own start is cut
/// off (sim/geometry/overrun.h).
std::vector<Vec2> simplify_outline(const std::vector<Vec2>& points, const PathSettings& settings = {});

/// The same for points in space on a surface with such normals, one for each point: simplified in the plane across
/// their mean, and lifted back to where the points lie (between them in a straight line).
std::vector<Vec3> simplify_in_space(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, bool outline,
                                    const PathSettings& settings = {});

}  // namespace limberg
