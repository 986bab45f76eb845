// Which triangles of the surface are of a flap: the skin over a pocket, the pocket's roof, and the walls around both.
// Seen along the chart, a roof looks the other way than the skin does, and lies over what it was raised from.
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "render/render_scene.h"

namespace limberg {

namespace {

constexpr double kColumn_mm = 0.5;  // of the grid on the chart in which what lies over what is looked up

using Column = int64_t;
Column column_of(const ChartPoint& p) {
  const auto x = int64_t(std::floor(p.x() / kColumn_mm)), y = int64_t(std::floor(p.y() / kColumn_mm));
  return x * (int64_t(1) << 32) + (y & 0xffffffff);
}

double turn_of(const std::array<ChartPoint, 3>& p) {
  const ChartPoint u = p[1] - p[0], v = p[2] - p[0];
  return u.x() * v.y() - u.y() * v.x();
}

}  // namespace

TissueMesh without_flaps(const TissueMesh& mesh, const SurfaceTopology& topology) {
  const SurfaceView& view = topology.view;
  std::vector<ChartPoint> chart(view.X_mm.size());
  for (size_t v = 0; v < chart.size(); ++v) chart[v] = topology.to_chart(view.X_mm[v]);
  const SharedArray<float>& depth = topology.depth_mm.get();
  const auto corners = [&](size_t t) {
    const Tri& c = view.tri[t];
    return std::array{chart[size_t(c[0])], chart[size_t(c[1])], chart[size_t(c[2])]};
  };
  const auto depth_of = [&](size_t t) {
    const Tri& c = view.tri[t];
    return double(depth[size_t(c[0])] + depth[size_t(c[1])] + depth[size_t(c[2])]) / 3;
  };
  double skin = 0;  // which way round its triangles go on the chart
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (topology.is_ground(t, Ground::skin)) skin += turn_of(corners(t));

  // The shallowest roof of each column. A wall that stands has no area on the chart and is none.
  std::unordered_map<Column, double> roof;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::wall) continue;
    const auto p = corners(t);
    const Tri& c = view.tri[t];
    const double area = turn_of(p), whole = (view.X_mm[size_t(c[1])] - view.X_mm[size_t(c[0])])
                                                .cross(view.X_mm[size_t(c[2])] - view.X_mm[size_t(c[0])])
                                                .norm();
    if (area * skin >= 0 || std::abs(area) < 0.5 * whole) continue;
    const double at = depth_of(t);
    const double longest = std::max({(p[1] - p[0]).norm(), (p[2] - p[1]).norm(), (p[0] - p[2]).norm()});
    const int n = 1 + int(std::ceil(2 * longest / kColumn_mm));
    for (int i = 0; i <= n; ++i)
      for (int k = 0; i + k <= n; ++k) {
        const double a = double(i) / n, b = double(k) / n;
        const auto [column, first] = roof.emplace(column_of((1 - a - b) * p[0] + a * p[1] + b * p[2]), at);
        if (!first) column->second = std::min(column->second, at);
      }
  }
  if (roof.empty()) return mesh;

  constexpr double kAtRoof_mm = 0.3, kInside_mm = 0.4;
  const auto of_flap = [&](size_t t) {
    if (view.kind[t] == FaceKind::free || view.kind[t] == FaceKind::fixed || topology.organ_of(t) != Organ::flesh)
      return false;
    const auto p = corners(t);
    ChartPoint middle = (p[0] + p[1] + p[2]) / 3;
    const double area = turn_of(p);
    if (view.kind[t] == FaceKind::wall) {
      const Tri& c = view.tri[t];
      const Vec3 normal =
          (view.X_mm[size_t(c[1])] - view.X_mm[size_t(c[0])]).cross(view.X_mm[size_t(c[2])] - view.X_mm[size_t(c[0])]);
      const double whole = normal.norm();
      if (area * skin > 0 && std::abs(area) > 0.5 * whole) return false;  // a bed
      // A wall is of the tissue behind it.
      if (std::abs(area) < 0.5 * whole && whole > 0)
        middle = topology.to_chart((view.X_mm[size_t(c[0])] + view.X_mm[size_t(c[1])] + view.X_mm[size_t(c[2])]) / 3 -
                                   kInside_mm * normal / whole);
    }
    const auto found = roof.find(column_of(middle));
    return found != roof.end() && depth_of(t) <= found->second + kAtRoof_mm;
  };

  TissueMesh bared = mesh;
  bared.tri.clear(), bared.tri_source.clear(), bared.triangles_of = {};
  for (size_t k = 0, part = 0, left = mesh.triangles_of[size_t(kTissueParts[0])]; k < mesh.tri.size(); ++k, --left) {
    while (left == 0) left = mesh.triangles_of[size_t(kTissueParts[++part])];
    if (of_flap(size_t(mesh.tri_source[k]))) continue;
    bared.tri.push_back(mesh.tri[k]), bared.tri_source.push_back(mesh.tri_source[k]);
    ++bared.triangles_of[size_t(kTissueParts[part])];
  }
  bared.skin_triangles = bared.triangles_of[size_t(Part::skin)];
  bared.wall_triangles = bared.triangles_of[size_t(Part::wall)];
  return bared;
}

}  // namespace limberg
