#include "sim/patient/anchors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/commands/plan_numbers.h"
#include "sim/geometry/polyline.h"

namespace limberg {
namespace {

// How far the hint moves towards the triangle's centroid: small against any triangle, large against rounding.
constexpr double kInside = 0.05;
// A carried hint is found again within this distance: it lies inside the old triangle, so inside one of its parts.
constexpr double kCarrySlack_mm = 1e-3;
// A buried bite lies this near to the rim that it belongs to: a blade at 45 degrees and half as much again.
constexpr double kBuriedReach = 1.5;
constexpr double kOneWall_mm = 0.01;  // a place is in a wall's tissue when it lies so deep behind it
constexpr double kFaces = 0.3;        // cosine: a cut face that lies along the skin rather than across it

Vec3 corner(const SurfaceView& v, size_t t, size_t k) { return v.X_mm[size_t(v.tri[t][k])]; }
Vec3 normal_of(const SurfaceView& v, size_t t) {
  const Vec3 a = corner(v, t, 0);
  return (corner(v, t, 1) - a).cross(corner(v, t, 2) - a);
}

}  // namespace

Anchor make_anchor(const SurfaceView& view, const RestIndex& index, const SurfacePoint& point) {
  Anchor a;
  a.at = point;
  a.X_mm = index.rest_mm(point);
  const SurfacePoint centre{point.triangle, Vec3::Constant(1.0 / 3)};
  a.hint_mm = (1 - kInside) * a.X_mm + kInside * index.rest_mm(centre);
  a.origin = view.origin[size_t(point.triangle)];
  return a;
}

std::optional<Anchor> make_buried_anchor(const SurfaceTopology& surface, const RestIndex& index,
                                         const SurfacePoint& rim, double depth_mm) {
  const SurfaceView& v = surface.view;
  const Vec3 R = index.rest_mm(rim);
  const size_t own = size_t(rim.triangle);
  const Vec3 n = normal_of(v, own).normalized();
  // From the rim into its own skin: square to the rim edges that the point lies on.
  Vec3 into = Vec3::Zero();
  for (size_t k = 0; k < 3; ++k)
    if ((v.rim[own] >> k & 1) && rim.bary[Eigen::Index((k + 2) % 3)] < 1e-6)
      into += n.cross(corner(v, own, (k + 1) % 3) - corner(v, own, k)).normalized();
  if (into.norm() < 1e-6) into = (corner(v, own, 0) + corner(v, own, 1) + corner(v, own, 2)) / 3 - R;
  into = (into - into.dot(n) * n).normalized();
  const double reach = kBuriedReach * depth_mm + 0.5;
  double best = reach * reach;
  std::optional<Anchor> found;
  const SharedArray<float>& depth = surface.depth_mm.get();
  for (size_t t = 0; t < v.tri.size(); ++t) {
    if (v.kind[t] != FaceKind::wall) continue;
    const double d[3] = {double(depth[size_t(v.tri[t][0])]), double(depth[size_t(v.tri[t][1])]),
                         double(depth[size_t(v.tri[t][2])])};
    if (std::min({d[0], d[1], d[2]}) > depth_mm || std::max({d[0], d[1], d[2]}) < depth_mm) continue;
    Vec3 out = normal_of(v, t);
    if (!(out.norm() > 0)) continue;
    out.normalize();
    if (out.dot(into) > -0.1) continue;  // the other bank's wall, or the floor
    // The line of that depth through the triangle: where two of its edges have it.
    std::vector<Vec3> ends;  // barycentric
    for (size_t k = 0; k < 3; ++k) {
      const size_t m = (k + 1) % 3;
      if ((d[k] - depth_mm) * (d[m] - depth_mm) > 0 || d[k] == d[m]) continue;
      const double s = (depth_mm - d[k]) / (d[m] - d[k]);
      Vec3 w = Vec3::Zero();
      w[Eigen::Index(k)] = 1 - s, w[Eigen::Index(m)] = s;
      ends.push_back(w);
    }
    if (ends.size() < 2) continue;
    const auto at = [&](const Vec3& w) {
      return Vec3(w[0] * corner(v, t, 0) + w[1] * corner(v, t, 1) + w[2] * corner(v, t, 2));
    };
    const Vec3 p = at(ends[0]), e = at(ends[1]) - p;
    const double s = e.squaredNorm() > 0 ? std::clamp((R - p).dot(e) / e.squaredNorm(), 0.0, 1.0) : 0;
    const Vec3 w = (1 - s) * ends[0] + s * ends[1];
    const double d2 = (at(w) - R).squaredNorm();
    if (d2 > best || (found && d2 == best)) continue;
    best = d2;
    Anchor a;
    a.at = {int32_t(t), w};
    a.X_mm = at(w);
    a.hint_mm = (1 - kInside) * a.X_mm + kInside * (corner(v, t, 0) + corner(v, t, 1) + corner(v, t, 2)) / 3;
    a.wall_normal = out;
    found = a;
  }
  return found;
}

std::optional<Anchor> make_wall_anchor(const SurfaceView& view, const RestIndex& index, const Skin& skin, const Vec3& X,
                                       HeldSide side) {
  const Vec3 up = skin.frame(X).normal;
  std::optional<Anchor> found;
  double best = kWallReach_mm * kWallReach_mm, behind_mm = 0;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::wall) continue;
    const Vec3 n = normal_of(view, t);
    if (!(n.norm() > 0)) continue;
    const double facing = n.normalized().dot(up);
    if (side == HeldSide::under ? facing > -kFaces : side == HeldSide::bed && facing < kFaces) continue;
    const SurfacePoint p{int32_t(t), index.weights(int32_t(t), X)};
    const Vec3 at = index.rest_mm(p);
    const double d2 = (at - X).squaredNorm();
    // The two walls of a cut lie in one place at rest: the one is meant whose tissue the place lies in.
    const bool same = found && std::abs(d2 - best) <= 1e-9 * (1 + best);
    if (same ? !(behind_mm >= -kOneWall_mm && (X - at).dot(n.normalized()) < -kOneWall_mm) : d2 > best) continue;
    best = d2, behind_mm = (X - at).dot(n.normalized());
    found = make_anchor(view, index, p);
    found->wall_normal = n.normalized();
  }
  return found;
}

std::optional<Anchor> carry_anchor(const Anchor& anchor, const SurfaceView& view, const RestIndex& index) {
  if (anchor.in_wall()) {
    Anchor next = anchor;
    double best = kCarrySlack_mm * kCarrySlack_mm;
    bool found = false;
    for (size_t t = 0; t < view.tri.size(); ++t) {
      if (view.kind[t] != FaceKind::wall) continue;
      const Vec3 n = normal_of(view, t);
      if (!(n.dot(anchor.wall_normal) > 0.9 * n.norm())) continue;
      const SurfacePoint p{int32_t(t), index.weights(int32_t(t), anchor.hint_mm)};
      const double d2 = (index.rest_mm(p) - anchor.hint_mm).squaredNorm();
      if (d2 > best || (found && d2 == best)) continue;
      best = d2, found = true;
      next.at = {p.triangle, index.weights(p.triangle, anchor.X_mm)};
    }
    return found ? std::optional<Anchor>(next) : std::nullopt;
  }
  const auto at = index.locate(anchor.hint_mm, anchor.origin, kCarrySlack_mm);
  if (!at || view.kind[size_t(at->triangle)] == FaceKind::wall) return std::nullopt;
  Anchor next = anchor;
  // The hint chose the bank; the weights are those of the held point itself on that triangle.
  next.at.triangle = at->triangle;
  next.at.bary = index.weights(at->triangle, anchor.X_mm);
  return next;
}

double row_stitches(const std::vector<Vec2>& a, const std::vector<Vec2>& b, double spacing_mm) {
  const double n = parts_of_row(std::max(path_length(a), path_length(b)), spacing_mm) + 1;
  return n < 2 ? 2 : n;
}

std::vector<Vec2> resample(const std::vector<Vec2>& path, int n) {
  const double total = path_length(path);
  std::vector<Vec2> out;
  out.reserve(size_t(n));
  size_t i = 1;
  double before = 0;  // arc length at path[i - 1]
  for (int k = 0; k < n; ++k) {
    const double s = total * k / (n - 1);
    while (i + 1 < path.size() && before + (path[i] - path[i - 1]).norm() < s)
      before += (path[i] - path[i - 1]).norm(), ++i;
    const double length = (path[i] - path[i - 1]).norm();
    const double t = length > 0 ? std::min(1.0, (s - before) / length) : 0;
    out.push_back(path[i - 1] + t * (path[i] - path[i - 1]));
  }
  return out;
}

std::string at_text(const ChartPoint& p) { return fmt::format("({:.2f}, {:.2f}) mm", p.x(), p.y()); }

}  // namespace limberg
