#include "sim/world/rest_index.h"

#include <algorithm>
#include <unordered_set>

#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

bool of_body(FaceKind k) { return k != FaceKind::wall; }

uint64_t edge_key(int32_t a, int32_t b) { return uint64_t(uint32_t(a)) << 32 | uint32_t(b); }

Vec3 closest_bary(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array<double, 3> w = closest_on_triangle(p, a, b, c).bary;
  return {w[0], w[1], w[2]};
}

}  // namespace

RestIndex::RestIndex(const SurfaceView& view, size_t body_triangles) : view_(&view) {
  first_.assign(body_triangles + 1, 0);
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (of_body(view.kind[t])) ++first_[size_t(view.origin[t]) + 1];
  for (size_t i = 0; i < body_triangles; ++i) first_[i + 1] += first_[i];
  by_origin_.resize(size_t(first_.back()));
  std::vector<int32_t> next(first_.begin(), first_.end() - 1);
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (of_body(view.kind[t])) by_origin_[size_t(next[size_t(view.origin[t])]++)] = int32_t(t);

  // The rim: edges of walls whose other side is skin. A wall edge without a wall behind it is a candidate; the skin
  // triangles that hold it are found by one scan that only looks at vertices on candidates.
  std::unordered_set<uint64_t> wall_edges;
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::wall)
      for (size_t k = 0; k < 3; ++k) wall_edges.emplace(edge_key(view.tri[t][k], view.tri[t][(k + 1) % 3]));
  std::vector<uint8_t> on_wall(view.X_mm.size(), 0);
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::wall)
      for (int32_t v : view.tri[t]) on_wall[size_t(v)] = 1;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    for (int k = 0; k < 3; ++k) {
      const int32_t a = view.tri[t][size_t(k)], b = view.tri[t][size_t((k + 1) % 3)];
      if (on_wall[size_t(a)] && on_wall[size_t(b)] && wall_edges.count(edge_key(b, a)))
        rim_.push_back({int32_t(t), k});
    }
  }
}

SurfacePoint RestIndex::closest_in(int32_t t, const Vec3& X, double& distance2) const {
  SurfacePoint p{t, closest_bary(X, corner(t, 0), corner(t, 1), corner(t, 2))};
  distance2 = (rest_mm(p) - X).squaredNorm();
  return p;
}

Vec3 RestIndex::rest_mm(const SurfacePoint& p) const {
  return p.bary.x() * corner(p.triangle, 0) + p.bary.y() * corner(p.triangle, 1) + p.bary.z() * corner(p.triangle, 2);
}

Vec3 RestIndex::weights(int32_t t, const Vec3& X_mm) const {
  return closest_bary(X_mm, corner(t, 0), corner(t, 1), corner(t, 2));
}

std::optional<SurfacePoint> RestIndex::locate(const Vec3& X_mm, int32_t origin, double slack_mm) const {
  if (origin < 0 || size_t(origin) + 1 >= first_.size()) return std::nullopt;
  std::optional<SurfacePoint> best;
  double best2 = slack_mm * slack_mm;
  for (int32_t i = first_[size_t(origin)]; i < first_[size_t(origin) + 1]; ++i) {
    double d2;
    const SurfacePoint p = closest_in(by_origin_[size_t(i)], X_mm, d2);
    if (d2 <= best2 && (!best || d2 < best2)) best2 = d2, best = p;
  }
  return best;
}

std::optional<SurfacePoint> RestIndex::nearest_skin(const Vec3& X_mm, double reach_mm) const {
  std::optional<SurfacePoint> best;
  double best2 = reach_mm * reach_mm;
  for (size_t t = 0; t < view_->tri.size(); ++t) {
    if (view_->kind[t] != FaceKind::skin) continue;
    double d2;
    const SurfacePoint p = closest_in(int32_t(t), X_mm, d2);
    if (d2 <= best2 && (!best || d2 < best2)) best2 = d2, best = p;
  }
  return best;
}

std::optional<SurfacePoint> RestIndex::snap_to_rim(const SurfacePoint& p, double reach_mm) const {
  const Vec3 X = rest_mm(p);
  std::optional<SurfacePoint> best;
  double best2 = reach_mm * reach_mm;
  for (const RimEdge& e : rim_) {
    const Vec3 a = corner(e.triangle, e.corner), b = corner(e.triangle, e.corner + 1), c = corner(e.triangle, e.corner + 2);
    const Vec3 ab = b - a;
    const double s = ab.squaredNorm() > 0 ? std::clamp((X - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
    const Vec3 q = a + s * ab;
    const double d2 = (X - q).squaredNorm();
    if (d2 > best2 || (best && d2 == best2)) continue;
    // The bank: the skin triangle must lie on the same side of its rim edge as the point. Where the point lies on the
    // edge itself, its own triangle decides.
    const Vec3 n = ab.cross(c - a), inward = n.cross(ab);
    const double side = inward.dot(X - q);
    if (side < 0 || (side == 0 && e.triangle != p.triangle)) continue;
    Vec3 w = Vec3::Zero();
    w[e.corner] = 1 - s;
    w[(e.corner + 1) % 3] = s;
    best2 = d2;
    best = SurfacePoint{e.triangle, w};
  }
  return best;
}

double RestIndex::rim_length_mm() const {
  double sum = 0;
  for (const RimEdge& e : rim_) sum += (corner(e.triangle, e.corner + 1) - corner(e.triangle, e.corner)).norm();
  return sum;
}

}  // namespace limberg
