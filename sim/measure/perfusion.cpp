#include "sim/measure/perfusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>

#include "sim/geometry/triangle.h"
#include "sim/measure/corners.h"

namespace limberg {
namespace {

constexpr double kOnSkin_mm = 1e-3, kFlat = 0.5, kNone_mm = 30, kFull_mm = 5;

// Per triangle, whether it is skin with a flat wall below it: the first wall on its way inwards that lies flat, before
// the way leaves the body. So neither the far side of a head counts, nor a cheek behind an ear, nor the mucosa of a
// lip.
std::vector<char> above_a_wall(const SurfaceView& view, const Skin& skin) {
  std::vector<char> out(view.tri.size(), 0);
  std::vector<Tri> wall;
  Vec3 lo = Vec3::Constant(1e300), hi = -lo;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::wall) continue;
    wall.push_back(view.tri[t]);
    for (const Vec3& X : corners_at_rest(view, t)) lo = lo.cwiseMin(X), hi = hi.cwiseMax(X);
  }
  if (wall.empty()) return out;
  const Bvh walls(view.X_mm.flat(), wall);
  const Vec3 reach = Vec3::Constant((hi - lo).norm());
  std::array<Bvh::LineHit, 64> hits;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    const auto X = corners_at_rest(view, t);
    const Vec3 m = (X[0] + X[1] + X[2]) / 3, n = area_vector2(X[0], X[1], X[2]).normalized();
    if (!n.allFinite() || (m.array() < (lo - reach).array()).any() || (m.array() > (hi + reach).array()).any())
      continue;
    int count = std::min<int>(skin.surface().line(m, -n, kOnSkin_mm, 1e4, hits), int(hits.size()));
    double end = 1e4;
    for (int i = 0; i < count && end == 1e4; ++i)
      if (!hits[size_t(i)].from_outside) end = hits[size_t(i)].t;
    count = std::min<int>(walls.line(m, -n, kOnSkin_mm, end, hits), int(hits.size()));
    for (int i = 0; i < count && !out[t]; ++i) {
      const Tri& w = wall[size_t(hits[size_t(i)].triangle)];
      const Vec3 up = area_vector2(view.X_mm[size_t(w[0])], view.X_mm[size_t(w[1])], view.X_mm[size_t(w[2])]);
      out[t] = std::abs(n.dot(up)) > kFlat * up.norm();
    }
  }
  return out;
}

}  // namespace

Perfusion perfusion(const SurfaceView& view, const Skin& skin) {
  Perfusion p;
  p.index.assign(view.tri.size(), -1);
  const std::vector<char> undermined = above_a_wall(view, skin);
  if (std::find(undermined.begin(), undermined.end(), char(1)) == undermined.end()) {
    for (size_t t = 0; t < view.tri.size(); ++t)
      if (view.kind[t] == FaceKind::skin) p.index[t] = 1;
    return p;
  }
  std::vector<Vec3> centre(view.tri.size());
  std::vector<double> way(view.tri.size(), std::numeric_limits<double>::infinity());
  std::map<std::pair<int32_t, int32_t>, int32_t> edge;  // directed, of skin
  std::priority_queue<std::pair<double, int32_t>, std::vector<std::pair<double, int32_t>>, std::greater<>> open;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    const auto X = corners_at_rest(view, t);
    centre[t] = (X[0] + X[1] + X[2]) / 3;
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
    const auto X = corners_at_rest(view, t);
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
