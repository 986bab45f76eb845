#include "sim/imaging/synthetic/synthetic_head.h"

#include <algorithm>
#include <cmath>

namespace limberg {
namespace {

/// Finest structures: 4.4 mm of bone at the condyle's neck, 7 mm of skin at the ear. Marched finer than they are thick.
constexpr double kBoneGrid_mm = 2.8, kSkinGrid_mm = 3.5;

simplex::Mesh part(std::function<double(const Vec3&)> f, const Vec3& low, const Vec3& high, double grid, double edge,
                   Workers& workers, LevelSetReport& report) {
  LevelSet s;
  s.distance_mm = std::move(f), s.lipschitz = HeadShape::kLipschitz, s.low_mm = low, s.high_mm = high;
  LevelSetSettings settings;
  settings.grid_mm = std::min(grid, 0.9 * edge), settings.edge_mm = edge;
  return mesh_level_set(s, settings, workers, &report);
}

}  // namespace

HeadModel make_head(const HeadSpec& spec, Workers& workers) {
  const HeadShape h(spec);
  HeadModel out;
  const Vec3 lo = HeadShape::low_mm(), hi = HeadShape::high_mm();
  out.cranium = part([&](const Vec3& p) { return h.skull(p); }, {lo.x(), lo.y(), -66}, hi, kBoneGrid_mm, spec.edge_mm,
                     workers, out.cranium_report);
  out.mandible = part([&](const Vec3& p) { return h.mandible(p); }, {-72, -12, -112}, {72, 116, -4}, kBoneGrid_mm,
                      spec.edge_mm, workers, out.mandible_report);
  out.face =
      part([&](const Vec3& p) { return h.skin(p); }, lo, hi, kSkinGrid_mm, spec.face_edge_mm, workers, out.face_report);
  out.landmarks = head_landmarks(h);
  return out;
}

}  // namespace limberg
