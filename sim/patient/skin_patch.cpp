#include "sim/patient/skin_patch.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace limberg {
namespace {

constexpr std::array<int, 3> kTipRing{6, 12, 24};  // places
constexpr int kBiteRays = 32;                      // of a whole turn; 4, 8, 16, ...
constexpr int kBiteRings =
    6;  // at .875 mm of cells and a bite of 2 mm more of both change a force by .1 % (2026-11-26)
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

SkinWalk::SkinWalk(const SurfaceView& view, const Vec3& middle, double reach, FaceKind kind) : view_(view) {
  for (int32_t t = 0; size_t(t) < view.tri.size(); ++t) {
    if (view.kind[size_t(t)] != kind) continue;
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

namespace {

// Unit vectors at n even angles, the first half of one from x, without the sines of a machine's own library: those of
// half an angle are square roots. `n`: 4, 8, 16, ... or 6, 12, 24, ...
std::vector<Vec2> even_turn(int n) {
  double c = n % 3 ? 0 : 0.5, s = n % 3 ? 1 : std::sqrt(0.75);  // of a quarter or a sixth of a turn
  for (int parts = n % 3 ? 4 : 6; parts < 2 * n; parts *= 2) {
    const double half = std::sqrt(0.5 * (1 + c));
    s = 0.5 * s / half, c = half;
  }
  const Vec2 step(c * c - s * s, 2 * c * s);
  std::vector<Vec2> turn{Vec2(c, s)};
  while (int(turn.size()) < n) {
    const Vec2& t = turn.back();
    turn.push_back(Vec2(t.x() * step.x() - t.y() * step.y(), t.x() * step.y() + t.y() * step.x()));
  }
  return turn;
}

// Axes in a triangle's plane; x along a wound's edge that the place lies on.
std::array<Vec3, 2> axes_at(const SurfaceView& view, const SurfacePoint& p) {
  const Vec3 normal = up_of(view, p.triangle);
  Eigen::Index flattest = 0;
  normal.cwiseAbs().minCoeff(&flattest);
  Vec3 e1 = Vec3::Unit(flattest);
  double off = 1e-6;
  for (int k = 0; k < 3; ++k) {
    const double beside = p.bary[(k + 2) % 3];
    if (!(view.rim[size_t(p.triangle)] >> k & 1) || !(beside < off)) continue;
    e1 = corner_of(view, p.triangle, k + 1) - corner_of(view, p.triangle, k), off = beside;
  }
  e1 = (e1 - e1.dot(normal) * normal).normalized();
  return {e1, normal.cross(e1)};
}

}  // namespace

std::vector<SurfacePoint> skin_patch(const SurfaceView& view, const SurfacePoint& middle, double radius_mm) {
  std::vector<SurfacePoint> places{middle};
  if (!(radius_mm > 0)) return places;
  const SkinWalk walk(view, place_of(view, middle), radius_mm, view.kind[size_t(middle.triangle)]);
  const auto [e1, e2] = axes_at(view, middle);
  // All places have the same part of the disc's area, r^2 / all; a ring's distance squared is the mean over its part,
  // and by 1 / all^2 more, for the middle has none.
  constexpr double all = 1 + kTipRing[0] + kTipRing[1] + kTipRing[2];
  double within = 1;
  for (const int n : kTipRing) {
    const double way = radius_mm * std::sqrt((within + 0.5 * n) * all / (all * all - 1));
    for (const Vec2& to : even_turn(n))
      if (const auto p = walk.ahead(middle, to[0] * e1 + to[1] * e2, way)) places.push_back(*p);
    within += n;
  }
  return places;
}

std::vector<PatchPlace> bite_patch(const SurfaceView& view, const SurfacePoint& middle, double radius_mm) {
  const Vec3 X = place_of(view, middle);
  const SkinWalk walk(view, X, radius_mm, view.kind[size_t(middle.triangle)]);
  const auto [e1, e2] = axes_at(view, middle);
  std::vector<PatchPlace> places;
  std::vector<Vec3> linear;  // 1 and the place in the plane of the middle, in units of the radius
  Mat3 M = Mat3::Zero();
  for (const Vec2& to : even_turn(kBiteRays))
    for (int ring = 0; ring < kBiteRings; ++ring) {
      const double way = (ring + 0.5) / kBiteRings;
      const auto at = walk.ahead(middle, to[0] * e1 + to[1] * e2, way * radius_mm);
      if (!at) break;  // nothing beyond a wound's edge
      const Vec3 d = (place_of(view, *at) - X) / radius_mm;
      places.push_back({*at, way});  // the area goes with the distance
      linear.emplace_back(1, d.dot(e1), d.dot(e2));
      M += way * linear.back() * linear.back().transpose();
    }
  // Of all shares m_i (l . p_i) with sum 1 and no first moment: M l = (1, 0, 0).
  const Eigen::CompleteOrthogonalDecomposition<Mat3> solve(M);
  const Vec3 l = solve.solve(Vec3::UnitX());
  if (places.empty() || !((M * l - Vec3::UnitX()).norm() < 1e-6)) return {{middle, 1}};
  for (size_t i = 0; i < places.size(); ++i) places[i].share *= l.dot(linear[i]);
  return places;
}

}  // namespace limberg
