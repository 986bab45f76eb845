#include "sim/patient/skin_patch.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace limberg {
namespace {

constexpr int kTipPlaces = 6;
// 1/7 of a ring's places lie in the middle, so 6/7 (x r)^2 = r^2 / 2.
const double kTipRing = std::sqrt(7.0 / 12);
// A walk starts this much of the way to its triangle's centroid, so that it starts at no edge and at no corner.
constexpr double kOffEdge = 1e-3;
constexpr int kMostCrossed = 1000;  // of one walk

Vec3 corner_of(const SurfaceView& v, int32_t t, int k) { return v.X_mm[size_t(v.tri[size_t(t)][size_t(k % 3)])]; }

Vec3 up_of(const SurfaceView& v, int32_t t) {
  return (corner_of(v, t, 1) - corner_of(v, t, 0)).cross(corner_of(v, t, 2) - corner_of(v, t, 0)).normalized();
}

Vec3 place_of(const SurfaceView& v, const SurfacePoint& p) {
  return p.bary[0] * corner_of(v, p.triangle, 0) + p.bary[1] * corner_of(v, p.triangle, 1) +
         p.bary[2] * corner_of(v, p.triangle, 2);
}

}  // namespace

SkinWalk::SkinWalk(const SurfaceView& view, const Vec3& middle, double reach) : view_(view) {
  for (int32_t t = 0; size_t(t) < view.tri.size(); ++t) {
    if (view.kind[size_t(t)] != FaceKind::skin) continue;
    const Vec3 a = corner_of(view, t, 0), b = corner_of(view, t, 1), c = corner_of(view, t, 2);
    const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    if ((low - middle).maxCoeff() > reach || (middle - high).maxCoeff() > reach) continue;
    for (size_t k = 0; k < 3; ++k) edge_.push_back({view.tri[size_t(t)][k], view.tri[size_t(t)][(k + 1) % 3], t});
  }
  std::sort(edge_.begin(), edge_.end());
}

int32_t SkinWalk::beyond(int32_t t, int edge) const {
  const int32_t u = view_.tri[size_t(t)][size_t(edge)], v = view_.tri[size_t(t)][size_t((edge + 1) % 3)];
  const auto next = std::lower_bound(edge_.begin(), edge_.end(), Edge{v, u, -1});
  return next == edge_.end() || next->from != v || next->to != u ? -1 : next->triangle;
}

std::optional<SurfacePoint> SkinWalk::ahead(const SurfacePoint& from, Vec3 d, double left) const {
  SurfacePoint at = from;
  at.bary = (1 - kOffEdge) * at.bary + Vec3::Constant(kOffEdge / 3);
  int entered = -1;  // the edge that the walk came in by
  for (int n = 0; n < kMostCrossed; ++n) {
    const int32_t t = at.triangle;
    const Vec3 normal = up_of(view_, t), p = place_of(view_, at);
    d = (d - d.dot(normal) * normal).normalized();
    if (!d.allFinite()) return std::nullopt;  // a triangle without an area
    // Barycentric weights change evenly along the way; the walk leaves where the first of them is used up.
    const double area2 =
        (corner_of(view_, t, 1) - corner_of(view_, t, 0)).cross(corner_of(view_, t, 2) - corner_of(view_, t, 0)).norm();
    Vec3 rate;
    double way = left;
    int out = -1;
    for (int k = 0; k < 3; ++k) {  // of the corner across the edge k + 1 -> k + 2
      rate[k] = normal.cross(corner_of(view_, t, k + 2) - corner_of(view_, t, k + 1)).dot(d) / area2;
      if ((k + 1) % 3 == entered || !(rate[k] < 0)) continue;
      const double to = std::max(0.0, -at.bary[k] / rate[k]);
      if (to < way) way = to, out = (k + 1) % 3;
    }
    at.bary += way * rate;
    left -= way;
    if (out < 0) return at;
    if (view_.rim[size_t(t)] >> out & 1) return std::nullopt;
    const int32_t next = beyond(t, out);
    if (next < 0) return std::nullopt;
    // Straight on: the part along the edge stays, the part across it turns with the triangle's plane.
    const Vec3 edge = (corner_of(view_, t, out + 1) - corner_of(view_, t, out)).normalized();
    const double along = d.dot(edge), across = std::sqrt(std::max(0.0, 1 - along * along));
    const Vec3 leave = p + way * d;
    at.triangle = next;
    for (int k = 0; k < 3; ++k)
      if (view_.tri[size_t(next)][size_t(k)] == view_.tri[size_t(t)][size_t((out + 1) % 3)]) entered = k;
    const Vec3 other = corner_of(view_, at.triangle, entered + 1) - corner_of(view_, at.triangle, entered);
    const double share =
        std::clamp((leave - corner_of(view_, at.triangle, entered)).dot(other) / other.squaredNorm(), 0.0, 1.0);
    at.bary.setZero();
    at.bary[entered] = 1 - share, at.bary[(entered + 1) % 3] = share;
    d = along * edge + across * up_of(view_, at.triangle).cross(other.normalized());
  }
  return std::nullopt;
}

std::vector<SurfacePoint> skin_patch(const SurfaceView& view, const SurfacePoint& middle, double radius_mm) {
  std::vector<SurfacePoint> places{middle};
  if (!(radius_mm > 0)) return places;
  const SkinWalk walk(view, place_of(view, middle), radius_mm);
  const Vec3 normal = up_of(view, middle.triangle);
  Eigen::Index flattest = 0;
  normal.cwiseAbs().minCoeff(&flattest);
  Vec3 e1 = Vec3::Unit(flattest);
  e1 = (e1 - e1.dot(normal) * normal).normalized();
  const Vec3 e2 = normal.cross(e1);
  // Cosines and sines of sixths of a turn, the same on every machine.
  const double half = 0.5, high = std::sqrt(0.75);
  const std::array<Vec2, kTipPlaces> turn{Vec2(1, 0), {half, high},   {-half, high},
                                          {-1, 0},    {-half, -high}, {half, -high}};
  for (const Vec2& to : turn)
    if (const auto p = walk.ahead(middle, to[0] * e1 + to[1] * e2, kTipRing * radius_mm)) places.push_back(*p);
  return places;
}

}  // namespace limberg
