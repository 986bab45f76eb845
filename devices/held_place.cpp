#include "devices/held_place.h"

#include <algorithm>

#include "devices/skin_chart.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

Vec3 corner_at_rest(const SurfaceView& v, size_t t, size_t k) { return v.X_mm[size_t(v.tri[t][k])]; }
Vec3 normal_at_rest(const SurfaceView& v, size_t t) {
  const Vec3 a = corner_at_rest(v, t, 0);
  return (corner_at_rest(v, t, 1) - a).cross(corner_at_rest(v, t, 2) - a).normalized();
}

}  // namespace

HeldSide side_of_face(const Vec3& normal, const Vec3& up) {
  constexpr double kFaces = 0.3;  // cosine: it lies along the skin rather than across it (sim/patient/anchors.cpp)
  const double facing = normal.dot(up);
  return facing > kFaces ? HeldSide::bed : facing < -kFaces ? HeldSide::under : HeldSide::wall;
}

std::optional<Vec3> held_place(const Snapshot& s, const Vec3& X, HeldSide side) {
  constexpr double kReach_mm = 4;
  if (!has_surface(s)) return std::nullopt;
  const SurfaceTopology& t = *s.topology;
  const Vec3 up = side == HeldSide::skin ? Vec3(Vec3::UnitZ()) : SkinChart::at_rest(s, X, 1e30).N;
  std::optional<Vec3> found;
  double best = kReach_mm * kReach_mm, in_tissue = 1;
  for (size_t i = 0; i < t.view.tri.size(); ++i) {
    const bool wanted = side == HeldSide::skin ? t.is_ground(i, Ground::skin) : t.view.kind[i] == FaceKind::wall;
    if (!wanted) continue;
    const Vec3 n = normal_at_rest(t.view, i);
    if (side != HeldSide::skin && side != HeldSide::wall && side_of_face(n, up) != side) continue;
    const TrianglePoint p = closest_on_triangle(X, corner_at_rest(t.view, i, 0), corner_at_rest(t.view, i, 1),
                                                corner_at_rest(t.view, i, 2));
    const double d2 = (p.point - X).squaredNorm(), behind = (X - p.point).dot(n);
    const bool same = found && std::abs(d2 - best) <= 1e-9 * (1 + best);
    if (same ? !(behind < in_tissue) : d2 > best) continue;
    best = d2, in_tissue = behind, found = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) *found += p.bary[k] * s.x_mm[size_t(t.view.tri[i][k])].cast<double>();
  }
  return found;
}

}  // namespace limberg
