#include "sim/cutting/strokes/sheet_mesh.h"

#include <algorithm>
#include <cmath>

#include "sim/cutting/arrangement/planar_split.h"
#include "sim/cutting/strokes/stroke.h"

namespace limberg {

std::optional<PlaneMesh> mesh_polygon(std::span<const Vec2> polygon, double spacing) {
  if (polygon.size() < 3) return std::nullopt;
  PlaneMesh mesh;
  mesh.vertex.assign(polygon.begin(), polygon.end());
  Vec2 lo = polygon[0], hi = lo;
  for (const Vec2& p : polygon) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  const double row = spacing * std::sqrt(0.75);
  int j = 0;
  for (double y = lo.y() + row / 2; y < hi.y(); y += row, ++j)
    for (double x = lo.x() + (j % 2 ? spacing / 2 : spacing); x < hi.x(); x += spacing) {
      const Vec2 p(x, y);
      if (!inside_polygon(polygon, p)) continue;
      double d = spacing;
      for (size_t i = 0; i < polygon.size() && d > spacing / 2; ++i)
        d = std::min(d, distance_to_segment(p, polygon[i], polygon[(i + 1) % polygon.size()]));
      if (d > spacing / 2) mesh.vertex.push_back(p);
    }

  // On integers inside a large triangle: the division used for cut faces does the rest, exactly.
  const Vec2 centre = (lo + hi) / 2;
  const double scale = double(1 << 18) / std::max((hi - lo).maxCoeff() / 2, 1e-9);
  PointStore points;
  constexpr int32_t big = 1 << 20;
  const std::array<int32_t, 3> frame{points.add_explicit({-big, -big, 0}), points.add_explicit({big, -big, 0}),
                                     points.add_explicit({0, big, 0})};
  const Plane plane = plane_through(points.integer(0), points.integer(1), points.integer(2));
  PlanarSplit split;
  split.open(points, plane, frame);
  for (const Vec2& p : mesh.vertex) {
    const Vec2 q = (p - centre) * scale;
    points.add_explicit({int32_t(std::lround(q.x())), int32_t(std::lround(q.y())), 0});
  }
  for (int32_t i = 0; i < int32_t(mesh.vertex.size()); ++i)
    if (!split.insert(i + 3, PlanarSplit::kFree)) return std::nullopt;
  const int32_t n = int32_t(polygon.size());
  for (int32_t i = 0; i < n; ++i)
    if (!split.enforce(i + 3, (i + 1) % n + 3, i)) return std::nullopt;
  split.make_delaunay();

  // Inside = reached from the left of the polygon's edges without crossing one.
  const auto pieces = split.pieces();
  std::vector<uint8_t> inside(pieces.size(), 0);
  std::vector<int32_t> stack;
  for (int32_t t = 0; t < int32_t(pieces.size()); ++t)
    for (size_t k = 0; k < 3; ++k) {
      const int32_t a = pieces[size_t(t)].v[k] - 3, b = pieces[size_t(t)].v[(k + 1) % 3] - 3;
      if (a >= 0 && a < n && b == (a + 1) % n && !inside[size_t(t)]) inside[size_t(t)] = 1, stack.push_back(t);
    }
  while (!stack.empty()) {
    const int32_t t = stack.back();
    stack.pop_back();
    for (size_t k = 0; k < 3; ++k) {
      const int32_t m = pieces[size_t(t)].neighbour[k];
      if (pieces[size_t(t)].label[k] != PlanarSplit::kFree || m < 0 || inside[size_t(m)]) continue;
      inside[size_t(m)] = 1;
      stack.push_back(m);
    }
  }
  for (size_t t = 0; t < pieces.size(); ++t) {
    if (!inside[t]) continue;
    const Tri tri{pieces[t].v[0] - 3, pieces[t].v[1] - 3, pieces[t].v[2] - 3};
    if (tri[0] < 0 || tri[1] < 0 || tri[2] < 0) return std::nullopt;
    mesh.tri.push_back(tri);
  }
  return mesh;
}

}  // namespace limberg
