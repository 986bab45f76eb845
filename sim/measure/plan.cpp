#include "sim/measure/plan.h"

#include <algorithm>

namespace limberg {
namespace {

double distance_to_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 e = b - a;
  const double t = e.squaredNorm() > 0 ? std::clamp((p - a).dot(e) / e.squaredNorm(), 0.0, 1.0) : 0;
  return (a + t * e - p).norm();
}

// Marks the points that matter between first and last. Its own stack: a hostile path may not exhaust the program's.
void mark(std::span<const ChartPoint> path, double tolerance, std::vector<char>& keep) {
  std::vector<std::pair<size_t, size_t>> open{{0, path.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    double worst = tolerance;
    size_t at = 0;
    for (size_t i = first + 1; i < last; ++i)
      if (const double d = distance_to_segment(path[i], path[first], path[last]); d > worst) worst = d, at = i;
    if (at == 0) continue;
    keep[at] = 1;
    open.push_back({first, at});
    open.push_back({at, last});
  }
}

}  // namespace

bool inside_polygon(const Vec2& p, std::span<const ChartPoint> polygon) {
  bool in = false;
  for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2 &a = polygon[i], &b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      in = !in;
  }
  return in;
}

std::vector<ChartPoint> corners_of_path(std::span<const ChartPoint> path, double tolerance_mm) {
  if (path.size() < 3) return {path.begin(), path.end()};
  std::vector<char> keep(path.size(), 0);
  keep.front() = keep.back() = 1;
  mark(path, tolerance_mm, keep);
  std::vector<ChartPoint> corners;
  for (size_t i = 0; i < path.size(); ++i)
    if (keep[i]) corners.push_back(path[i]);
  return corners;
}

std::vector<ChartPoint> corners_of_outline(std::span<const ChartPoint> outline, double tolerance_mm) {
  if (outline.size() < 3) return {outline.begin(), outline.end()};
  // The point farthest from the centre is a corner whatever the shape: start and end there.
  Vec2 centre = Vec2::Zero();
  for (const auto& p : outline) centre += p / double(outline.size());
  const auto start = std::max_element(outline.begin(), outline.end(), [&](const auto& a, const auto& b) {
    return (a - centre).squaredNorm() < (b - centre).squaredNorm();
  });
  std::vector<ChartPoint> ring(start, outline.end());
  ring.insert(ring.end(), outline.begin(), start);
  ring.push_back(*start);
  std::vector<ChartPoint> corners = corners_of_path(ring, tolerance_mm);
  corners.pop_back();
  while (corners.size() > 1 && (corners.back() - corners.front()).norm() <= tolerance_mm) corners.pop_back();
  return corners;
}

std::optional<CentralLimb> find_central_limb(std::span<const Command> script) {
  for (const Command& c : script) {
    const auto* cut = std::get_if<Incise>(&c);
    if (!cut) continue;
    const auto p = corners_of_path(cut->path);
    if (p.size() != 4) continue;
    const Vec2 ab = p[2] - p[1];
    if (cross2(ab, p[0] - p[1]) * cross2(ab, p[3] - p[2]) < 0) return CentralLimb{p[0], p[1], p[2], p[3]};
  }
  return std::nullopt;
}

std::optional<TranspositionFlap> find_transposition_flap(std::span<const Command> script) {
  std::vector<std::vector<ChartPoint>> defects;
  for (const Command& c : script) {
    if (const auto* e = std::get_if<Excise>(&c)) {
      auto corners = corners_of_outline(e->outline);
      if (corners.size() == 4) defects.push_back(std::move(corners));
    }
    const auto* cut = std::get_if<Incise>(&c);
    if (!cut) continue;
    const auto p = corners_of_path(cut->path);
    if (p.size() != 3) continue;
    for (const auto& d : defects)
      for (size_t i = 0; i < 4; ++i) {
        if ((d[i] - p[0]).norm() > 2) continue;
        const Vec2 &next = d[(i + 1) % 4], &last = d[(i + 3) % 4];
        return TranspositionFlap{(next - p[2]).norm() < (last - p[2]).norm() ? next : last, p[0], p[1], p[2]};
      }
  }
  return std::nullopt;
}

}  // namespace limberg
