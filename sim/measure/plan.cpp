#include "sim/measure/plan.h"

#include <algorithm>

#include "sim/geometry/polyline.h"

namespace limberg {

std::vector<ChartPoint> corners_of_path(std::span<const ChartPoint> path, double tolerance_mm) {
  return simplify(path, tolerance_mm);
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
