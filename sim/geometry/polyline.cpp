#include "sim/geometry/polyline.h"

namespace limberg {

double signed_area(std::span<const Vec2> polygon) {
  double a = 0;
  for (size_t i = 0; i < polygon.size(); ++i) a += cross2(polygon[i], polygon[(i + 1) % polygon.size()]);
  return a / 2;
}

bool inside_polygon(std::span<const Vec2> polygon, const Vec2& p) {
  bool in = false;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) in = !in;
  }
  return in;
}

std::optional<double> meet_segments(const Vec2& p, const Vec2& q, const Vec2& a, const Vec2& b) {
  // What meets has boxes that meet, which needs no rounding. (Of two parts of one line the determinant is rounding
  // alone, and its quotients may be anything.)
  for (int k = 0; k < 2; ++k)
    if (std::max(p[k], q[k]) < std::min(a[k], b[k]) || std::max(a[k], b[k]) < std::min(p[k], q[k])) return std::nullopt;
  const Vec2 d = q - p, e = b - a;
  const double det = cross2(d, e);
  if (det == 0) return std::nullopt;
  const double s = cross2(a - p, e) / det, t = cross2(a - p, d) / det;
  if (s < 0 || s > 1 || t < 0 || t > 1) return std::nullopt;
  return s;
}

namespace {

template <class Point>
void keep_corners_of(std::span<const Point> path, size_t first, size_t last, double tolerance,
                     std::span<uint8_t> keep) {
  std::vector<std::pair<size_t, size_t>> stack{{first, last}};
  while (!stack.empty()) {
    const auto [a, b] = stack.back();
    stack.pop_back();
    double worst = tolerance;
    size_t at = a;
    for (size_t i = a + 1; i < b; ++i)
      if (const double d = distance_to_segment(path[i], path[a], path[b]); d > worst) worst = d, at = i;
    if (at == a) continue;
    keep[at] = 1;
    stack.push_back({a, at});
    stack.push_back({at, b});
  }
}

template <class Point>
std::vector<Point> simplified(std::span<const Point> path, double tolerance) {
  if (path.size() < 3) return {path.begin(), path.end()};
  std::vector<uint8_t> keep(path.size(), 0);
  keep.front() = keep.back() = 1;
  keep_corners_of(path, 0, path.size() - 1, tolerance, keep);
  std::vector<Point> out;
  for (size_t i = 0; i < path.size(); ++i)
    if (keep[i]) out.push_back(path[i]);
  return out;
}

}  // namespace

void keep_corners(std::span<const Vec2> path, size_t first, size_t last, double tolerance, std::span<uint8_t> keep) {
  keep_corners_of(path, first, last, tolerance, keep);
}

std::vector<Vec2> simplify(std::span<const Vec2> path, double tolerance) { return simplified(path, tolerance); }
std::vector<Vec3> simplify(std::span<const Vec3> path, double tolerance) { return simplified(path, tolerance); }

}  // namespace limberg
