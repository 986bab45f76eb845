#include "sim/cutting/arrangement/wound.h"

#include <algorithm>
#include <cmath>

#include "sim/cutting/arrangement/store.h"
#include "sim/geometry/polyline.h"

namespace limberg {

WoundMap::WoundMap(const BladeContext& context) {
  if (!context.arrangement) return;
  const Arrangement& a = *context.arrangement;
  const ArrangementStore& s = a.store();
  std::vector<std::pair<int32_t, int32_t>> ends;  // point, edge
  const int32_t body = s.op.size() > 1 ? s.op[1].first_orig : 0;
  const Chart chart = context.chart();
  for (int32_t o = 0; o < body; ++o) {
    if (s.orig[o].split < 0 || s.orig[o].live == 0 || a.kind_of_orig(o) != FaceKind::skin) continue;
    const auto& plane = s.orig[o].plane;
    const Vec3 normal(double(plane.n[0]), double(plane.n[1]), double(plane.n[2]));
    for (const Constraint& c : a.constraints_of(o))
      if (s.edges.first(c.a, c.b) >= 0 && context.shows(a.point_mm(c.a), normal)) {
        ends.push_back({c.a, int32_t(edge_.size())});
        ends.push_back({c.b, int32_t(edge_.size())});
        edge_.push_back({chart.to_chart(a.point_mm(c.a)), chart.to_chart(a.point_mm(c.b))});
      }
  }
  std::sort(ends.begin(), ends.end());
  for (size_t i = 0; i < ends.size(); ++i) {
    if ((i > 0 && ends[i - 1].first == ends[i].first) || (i + 1 < ends.size() && ends[i + 1].first == ends[i].first))
      continue;
    const WoundEdge& e = edge_[size_t(ends[i].second)];
    const Vec2 p = chart.to_chart(a.point_mm(ends[i].first));
    const Vec2 d = (p - e.a).squaredNorm() < (p - e.b).squaredNorm() ? e.b - e.a : e.a - e.b;
    if (d.norm() > 0) end_.push_back({p, d.normalized()});
  }
}

Vec2 WoundMap::clear_of_ends(const Vec2& p, double clearance) const {
  for (const FreeEnd& e : end_)
    if ((p - e.at).norm() < clearance) return nearest(e.at + e.inward * clearance).point;
  return p;
}

std::optional<WoundMap::FreeEnd> WoundMap::free_end_near(const Vec2& p, double reach) const {
  std::optional<FreeEnd> best;
  for (const FreeEnd& e : end_)
    if ((p - e.at).norm() <= (best ? (p - best->at).norm() : reach)) best = e;
  return best;
}

WoundMap::Near WoundMap::nearest(const Vec2& p) const {
  Near best;
  for (const WoundEdge& e : edge_) {
    const Vec2 d = e.b - e.a;
    const double l = d.squaredNorm(), t = l > 0 ? std::clamp((p - e.a).dot(d) / l, 0.0, 1.0) : 0.0;
    const Vec2 q = e.a + t * d;
    const double distance = (q - p).norm();
    if (distance < best.distance) best = {q, l > 0 ? Vec2(d / std::sqrt(l)) : Vec2(Vec2::UnitX()), distance};
  }
  return best;
}

std::optional<double> WoundMap::first_meeting(const Vec2& p, const Vec2& q) const {
  std::optional<double> first;
  for (const WoundEdge& e : edge_) {
    const auto s = meet_segments(p, q, e.a, e.b);
    if (s && (!first || *s < *first)) first = s;
  }
  return first;
}

bool skin_is_live(const BladeContext& context, const ChartPoint& p) {
  const auto hit = context.skin(p);
  if (!hit || hit->triangle < 0) return false;
  const Arrangement& a = *context.arrangement;
  const auto pieces = a.faces_of_orig(hit->triangle);
  if (pieces.size() == 1) return a.faces()[pieces[0]].live();
  // The piece that the point lies deepest in.
  const Plane& plane = a.orig_tris()[hit->triangle].plane;
  const Vec3 n = Vec3(double(plane.n[0]), double(plane.n[1]), double(plane.n[2])).normalized();
  double best = -1e300;
  bool live = false;
  for (int32_t f : pieces) {
    const Face& face = a.faces()[f];
    double depth = 1e300;
    for (size_t k = 0; k < 3; ++k) {
      const Vec3 u = a.point_mm(face.v[k]), v = a.point_mm(face.v[(k + 1) % 3]);
      depth = std::min(depth, n.cross((v - u).normalized()).dot(hit->X_mm - u));
    }
    if (depth > best) best = depth, live = face.live();
  }
  return live;
}

}  // namespace limberg
