#include "sim/cutting/strokes/stroke_runs.h"

#include <algorithm>
#include <cmath>

#include "sim/cutting/strokes/blade_parts.h"
#include "sim/cutting/strokes/pull_back.h"

namespace limberg {

namespace {

constexpr double kCosine = 0.9659;  // 15 degrees: still along a wall
constexpr double kSharp = 0.94;     // cosine: a corner at which a leaning blade may turn upright

/// Would a blade held at this angle lie on that wall, within 15 degrees?
bool blades_alike(const BladeContext& c, const WallMap& walls, const WallMap::Along& at, const Vec2& p, const Vec2& way,
                  double lean) {
  const auto k = column_at(c, p);
  if (!k) return false;
  const Chart chart = c.chart();
  const Vec3 along = chart.e1 * way.x() + chart.e2 * way.y();
  const WallStrip& t = walls.strips()[size_t(at.strip)];
  const auto on_wall = [&](const Vec3& blade) {
    return std::all_of(t.column.begin(), t.column.end(), [&](int32_t i) {
      return blade.normalized().dot(walls.columns()[size_t(i)].down.normalized()) >= kCosine;
    });
  };
  if (on_wall(-k->normal + along.cross(k->normal).normalized() * lean)) return true;
  // Beside a wound that gapes the skin is turned: as it lies now, or as it lay.
  const auto hit = c.gradient ? c.skin(p) : std::nullopt;
  if (!hit) return false;
  const Vec3 in_skin = (along - along.dot(k->normal) * k->normal).normalized();
  return on_wall(-k->normal + aside_at_rest(c.gradient(*hit), k->normal, in_skin, lean));
}

}  // namespace

size_t AlongSamples::block_end(size_t i) const {
  size_t j = i;
  while (j < along.size() && along[j] == along[i]) ++j;
  return j;
}

bool AlongSamples::drifts(size_t first, size_t last) const {
  return std::abs(offset[last] - offset[first]) > std::max(0.7 * kSnap, 0.06 * (arc(last) - arc(first)));
}

AlongSamples samples_along(const BladeContext& c, const WallMap& walls, std::span<const Vec2> path, double lean,
                           double depth_mm) {
  AlongSamples s;
  s.length = path_length(path);
  const size_t n = size_t(std::ceil(s.length / kStep)) + 1;
  s.along.assign(n, 0);
  s.offset.assign(n, 0);
  std::vector<Vec2> p(n, path.back());
  std::vector<uint8_t> near(n, 0);
  double arc = 0;
  for (size_t i = 0, k = 0; i + 1 < path.size(); ++i) {
    const double l = (path[i + 1] - path[i]).norm();
    for (; k < n && double(k) * kStep <= arc + l; ++k)
      if (l > 0) p[k] = path[i] + (path[i + 1] - path[i]) * ((double(k) * kStep - arc) / l);
    arc += l;
  }
  std::vector<double> sharp;
  for (size_t i = 1; i + 1 < path.size(); ++i)
    if ((path[i] - path[i - 1]).normalized().dot((path[i + 1] - path[i]).normalized()) < kSharp)
      sharp.push_back(path_length(path.first(i + 1)));
  const double reach = 3 * (depth_mm + kMargin) * std::abs(lean) + kSpacing;
  for (size_t i = 0; i < n; ++i) {
    const WallMap::Along w = walls.nearest(p[i], kSnap);
    if (w.strip < 0) continue;
    near[i] = 1;
    const Vec2 way = (p[std::min(i + kWindow, n - 1)] - p[i < kWindow ? 0 : i - kWindow]).normalized();
    if (std::abs(way.dot(w.direction)) < kCosine) continue;
    const bool at_corner =
        lean != 0 && std::any_of(sharp.begin(), sharp.end(), [&](double a) { return std::abs(a - s.arc(i)) < reach; });
    for (const double share : {1.0, 0.67, 0.33, 0.0})
      if (!s.along[i] && (share == 1 || at_corner)) s.along[i] = blades_alike(c, walls, w, p[i], way, share * lean);
    s.offset[i] = way.dot(w.direction) > 0 ? w.offset : -w.offset;
  }
  for (size_t i = 0, j = 0; i < n; i = j) {
    j = s.block_end(i);
    const double l = double(j - i) * kStep;
    const bool corner =
        l <= kCorner && std::all_of(near.begin() + long(i), near.begin() + long(j), [](uint8_t x) { return x != 0; });
    if (!s.along[i] && i > 0 && j < n && (l <= kGap || corner)) {
      std::fill(s.along.begin() + long(i), s.along.begin() + long(j), 1);
      j = s.block_end(i);
    }
  }
  return s;
}

}  // namespace limberg
