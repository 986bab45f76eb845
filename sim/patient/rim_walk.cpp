#include "sim/patient/rim_walk.h"

#include <algorithm>
#include <map>

namespace limberg {

RimWalk::RimWalk(const SurfaceView& view) : view_(view) {
  std::map<int32_t, std::vector<int32_t>> from;  // by vertex: edges that leave it
  for (size_t t = 0; t < view_.tri.size(); ++t)
    for (int32_t k = 0; k < 3; ++k)
      if (view_.rim[t] >> k & 1) {
        const int32_t a = view_.tri[t][size_t(k)], b = view_.tri[t][size_t((k + 1) % 3)];
        from[a].push_back(int32_t(edge_.size()));
        edge_.push_back({int32_t(t), k, -1, -1, (view_.X_mm[size_t(b)] - view_.X_mm[size_t(a)]).norm()});
      }
  for (size_t i = 0; i < edge_.size(); ++i) {
    Edge& e = edge_[i];
    const auto at = from.find(view_.tri[size_t(e.triangle)][size_t((e.corner + 1) % 3)]);
    if (at == from.end()) continue;  // the skin ends there
    // Where rims touch in one vertex each edge has one to follow it: those that are free, in their order.
    for (int32_t n : at->second)
      if (edge_[size_t(n)].before < 0) {
        e.next = n, edge_[size_t(n)].before = int32_t(i);
        break;
      }
  }
}

std::optional<RimWalk::Spot> RimWalk::spot(const SurfacePoint& p) const {
  std::optional<Spot> best;
  double best2 = 1e-6;
  const auto corner = [&](size_t k) { return view_.X_mm[size_t(view_.tri[size_t(p.triangle)][k % 3])]; };
  const Vec3 X = p.bary[0] * corner(0) + p.bary[1] * corner(1) + p.bary[2] * corner(2);
  for (size_t i = 0; i < edge_.size(); ++i) {
    if (edge_[i].triangle != p.triangle) continue;
    const Vec3 a = corner(size_t(edge_[i].corner)), ab = corner(size_t(edge_[i].corner) + 1) - a;
    const double s = ab.squaredNorm() > 0 ? std::clamp((X - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0;
    const double d2 = (a + s * ab - X).squaredNorm();
    if (d2 < best2) best2 = d2, best = Spot{int32_t(i), s};
  }
  return best;
}

std::optional<RimWalk::Way> RimWalk::way(const Spot& from, const Spot& to, bool forward) const {
  Way w;
  w.forward = forward;
  w.corner.push_back({from, 0});
  Spot here = from;
  for (size_t steps = 0; steps <= edge_.size() + 1; ++steps) {
    const Edge& e = edge_[size_t(here.edge)];
    if (here.edge == to.edge && (forward ? to.at >= here.at : to.at <= here.at)) {
      w.length_mm += std::abs(to.at - here.at) * e.length_mm;
      w.corner.push_back({to, w.length_mm});
      return w;
    }
    w.length_mm += (forward ? 1 - here.at : here.at) * e.length_mm;
    w.corner.push_back({{here.edge, forward ? 1.0 : 0.0}, w.length_mm});
    const int32_t next = forward ? e.next : e.before;
    if (next < 0) return std::nullopt;
    here = {next, forward ? 0.0 : 1.0};
    w.corner.push_back({here, w.length_mm});
  }
  return std::nullopt;
}

SurfacePoint RimWalk::point(const Way& w, double share) const {
  const double s = std::clamp(share, 0.0, 1.0) * w.length_mm;
  size_t i = 1;
  while (i + 1 < w.corner.size() && w.corner[i].second < s) ++i;
  Spot at = w.corner[i].first;  // both ends of a piece are on one edge, where it has a length
  const double piece = w.corner[i].second - w.corner[i - 1].second;
  if (piece > 0) at.at += (w.corner[i - 1].first.at - at.at) * (w.corner[i].second - s) / piece;
  return point(at);
}

SurfacePoint RimWalk::point(const Spot& at) const {
  const Edge& e = edge_[size_t(at.edge)];
  SurfacePoint p{e.triangle, Vec3::Zero()};
  p.bary[e.corner] = 1 - at.at;
  p.bary[(e.corner + 1) % 3] = at.at;
  return p;
}

std::optional<SurfacePoint> RimWalk::along(const Spot& from, double by_mm) const {
  const bool forward = by_mm >= 0;
  Spot here = from;
  double left = std::abs(by_mm);
  for (size_t steps = 0; steps <= edge_.size(); ++steps) {
    const Edge& e = edge_[size_t(here.edge)];
    const double rest = (forward ? 1 - here.at : here.at) * e.length_mm;
    if (left <= rest && e.length_mm > 0)
      return point(Spot{here.edge, here.at + (forward ? left : -left) / e.length_mm});
    left -= rest;
    const int32_t next = forward ? e.next : e.before;
    if (next < 0) return std::nullopt;
    here = {next, forward ? 0.0 : 1.0};
  }
  return std::nullopt;
}

}  // namespace limberg
