#include "sim/measure/perfusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>

#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr double kGrid_mm = 0.5, kFlat = 0.5, kNone_mm = 30, kFull_mm = 5;

std::array<Vec3, 3> corners(const SurfaceView& v, size_t t) {
  return {v.X_mm[size_t(v.tri[t][0])], v.X_mm[size_t(v.tri[t][1])], v.X_mm[size_t(v.tri[t][2])]};
}

std::pair<int, int> square(const Vec2& p) {
  return {int(std::floor(p.x() / kGrid_mm)), int(std::floor(p.y() / kGrid_mm))};
}

/// A chart is a projection, and a closed body has skin twice above a place of it: on the side that faces the chart, and
/// on its far side.
using Place = std::pair<bool, std::pair<int, int>>;
bool faces_chart(const Vec3& normal, const Skin& skin) { return normal.dot(skin.body().chart_normal()) > 0; }

// Squares of the chart that have a flat wall below them, on the side to whose skin it is nearest.
std::set<Place> floors(const SurfaceView& view, const Skin& skin) {
  std::set<Place> out;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::wall) continue;
    const auto X = corners(view, t);
    const Vec3 n = area_vector2(X[0], X[1], X[2]), m = (X[0] + X[1] + X[2]) / 3;
    const Vec3 up = skin.nearest(m).normal;
    if (!(std::abs(n.dot(up)) > kFlat * n.norm())) continue;
    const bool front = faces_chart(up, skin);
    Vec2 c[3], lo = Vec2::Constant(1e300), hi = -lo;
    for (size_t k = 0; k < 3; ++k) c[k] = skin.body().to_chart(X[k]), lo = lo.cwiseMin(c[k]), hi = hi.cwiseMax(c[k]);
    out.insert({front, square(skin.body().to_chart(m))});
    const auto a = square(lo), b = square(hi);
    const auto left = [](const Vec2& p, const Vec2& q, const Vec2& r) {
      return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
    };
    for (int i = a.first; i <= b.first; ++i)
      for (int k = a.second; k <= b.second; ++k) {
        const Vec2 p((i + 0.5) * kGrid_mm, (k + 0.5) * kGrid_mm);
        const double s[3] = {left(c[0], c[1], p), left(c[1], c[2], p), left(c[2], c[0], p)};
        if ((s[0] >= 0 && s[1] >= 0 && s[2] >= 0) || (s[0] <= 0 && s[1] <= 0 && s[2] <= 0)) out.insert({front, {i, k}});
      }
  }
  return out;
}

}  // namespace

Perfusion perfusion(const SurfaceView& view, const Skin& skin) {
  Perfusion p;
  p.index.assign(view.tri.size(), -1);
  const auto below = floors(view, skin);
  if (below.empty()) {
    for (size_t t = 0; t < view.tri.size(); ++t)
      if (view.kind[t] == FaceKind::skin) p.index[t] = 1;
    return p;
  }
  std::vector<Vec3> centre(view.tri.size());
  std::vector<double> way(view.tri.size(), std::numeric_limits<double>::infinity());
  std::map<std::pair<int32_t, int32_t>, int32_t> edge;  // directed, of skin
  std::priority_queue<std::pair<double, int32_t>, std::vector<std::pair<double, int32_t>>, std::greater<>> open;
  std::vector<char> undermined(view.tri.size(), 0);
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    const auto X = corners(view, t);
    centre[t] = (X[0] + X[1] + X[2]) / 3;
    const bool front = faces_chart(area_vector2(X[0], X[1], X[2]), skin);
    undermined[t] = below.count({front, square(skin.body().to_chart(centre[t]))}) > 0;
    for (size_t k = 0; k < 3; ++k) edge[{view.tri[t][k], view.tri[t][(k + 1) % 3]}] = int32_t(t);
    if (!undermined[t]) way[t] = 0, open.push({0, int32_t(t)});
  }
  const auto beyond = [&](int32_t t, size_t k) {  // undermined skin over that edge
    const auto mate = edge.find({view.tri[size_t(t)][(k + 1) % 3], view.tri[size_t(t)][k]});
    return mate == edge.end() || !undermined[size_t(mate->second)] ? -1 : mate->second;
  };
  while (!open.empty()) {
    const auto [d, t] = open.top();
    open.pop();
    if (d > way[size_t(t)]) continue;
    // To the neighbours and, straight, to theirs: a way over neighbours alone zigzags.
    const double from = d;
    const Vec3& here = centre[size_t(t)];
    const auto relax = [&](int32_t to) {
      const double next = from + (centre[size_t(to)] - here).norm();
      if (next < way[size_t(to)]) way[size_t(to)] = next, open.push({next, to});
    };
    for (size_t k = 0; k < 3; ++k) {
      const int32_t m = beyond(t, k);
      if (m < 0) continue;
      relax(m);
      for (size_t j = 0; j < 3; ++j)
        if (const int32_t n = beyond(m, j); n >= 0) relax(n);
    }
  }
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    const auto X = corners(view, t);
    const double area = 0.5 * area_vector2(X[0], X[1], X[2]).norm();
    const double f = std::isfinite(way[t]) ? std::clamp((kNone_mm - way[t]) / (kNone_mm - kFull_mm), 0.0, 1.0) : 0;
    p.index[t] = float(f);
    p.least = std::min(p.least, f);
    if (undermined[t]) p.undermined_mm2 += area;
    if (!std::isfinite(way[t]))
      p.severed_mm2 += area;
    else
      p.farthest_mm = std::max(p.farthest_mm, way[t]);
    if (f < 0.4) p.below_40_mm2 += area;
  }
  return p;
}

}  // namespace limberg
