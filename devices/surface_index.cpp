#include "devices/surface_index.h"

#include <algorithm>
#include <cmath>

#include "sim/geometry/polyline.h"
#include "sim/geometry/triangle.h"

namespace limberg {

namespace {

constexpr int kMaxWalk = 2000;

const Vec3f& float_at(const Snapshot& s, int32_t v) { return s.x_mm[size_t(v)]; }

}  // namespace

size_t VertexSet::place(int32_t v) const {
  size_t at = (size_t(uint32_t(v)) * 2654435761u) & (slot_.size() - 1);
  while (slot_[at] >= 0 && slot_[at] != v) at = (at + 1) & (slot_.size() - 1);
  return at;
}

bool VertexSet::insert(int32_t v) {
  const size_t at = place(v);
  if (slot_[at] == v) return true;
  if (order_.size() == kMost) return false;
  slot_[at] = v;
  order_.push_back(v);
  return true;
}

void VertexSet::clear() {
  if (!order_.empty()) std::fill(slot_.begin(), slot_.end(), -1);
  order_.clear();
}

bool SurfaceIndex::another(const Snapshot& s) {
  if (looked_ && version_ == s.topology->version) return false;
  looked_ = true, version_ = s.topology->version;
  return true;
}

SkinTouch touch_at(const Snapshot& s, int32_t triangle, const std::array<double, 3>& bary, double distance_mm) {
  SkinTouch out;
  if (triangle < 0) return out;
  const SurfaceView& view = s.topology->view;
  const Tri& k = view.tri[size_t(triangle)];
  const Vec3 a = float_at(s, k[0]).cast<double>(), b = float_at(s, k[1]).cast<double>(),
             c = float_at(s, k[2]).cast<double>();
  out.triangle = triangle;
  out.bary = bary;
  out.x_mm = bary[0] * a + bary[1] * b + bary[2] * c;
  out.X_mm = Vec3::Zero();
  for (size_t i = 0; i < 3; ++i) out.X_mm += bary[i] * view.X_mm[size_t(k[i])];
  const Vec3 N = area_vector2(view.X_mm[size_t(k[0])], view.X_mm[size_t(k[1])], view.X_mm[size_t(k[2])]);
  if (N.norm() > 0) out.N = N.normalized();
  out.chart = s.topology->to_chart(out.X_mm);
  const Vec3 n = area_vector2(a, b, c);
  if (n.norm() > 0) out.normal = n.normalized();
  out.distance_mm = distance_mm;
  return out;
}

SkinTouch SurfaceIndex::touch(const Snapshot& s, const Place& place) const {
  return touch_at(s, place.triangle, place.bary, std::sqrt(place.distance2));
}

SurfaceIndex::Place SurfaceIndex::nearer(const Snapshot& s, const Vec3& p, Place best) const {
  const SurfaceView& view = s.topology->view;
  for (const int32_t t : of(s).triangle) {
    const Tri& k = view.tri[size_t(t)];
    const Vec3 a = float_at(s, k[0]).cast<double>(), b = float_at(s, k[1]).cast<double>(),
               c = float_at(s, k[2]).cast<double>();
    const Vec3 beside = (a.cwiseMin(b).cwiseMin(c) - p).cwiseMax(p - a.cwiseMax(b).cwiseMax(c)).cwiseMax(0);
    if (beside.squaredNorm() >= best.distance2 || marked(s, t)) continue;
    const TrianglePoint at = closest_on_triangle(p, a, b, c);
    Place found{t, at.bary, (at.point - p).squaredNorm()};
    if (mark_.size() > 0) found = walk(s, p, t);  // beyond the border of a marked sheet it goes on as the same skin
    if (found.distance2 < best.distance2 && !marked(s, found.triangle)) best = found;
  }
  return best;
}

SkinTouch SurfaceIndex::closest_of_all(const Snapshot& s, const Vec3& p) const {
  const SkinTouch near = closest(s, p, -1);
  if (near.triangle < 0) return near;
  return touch(s, nearer(s, p, {near.triangle, near.bary, near.distance_mm * near.distance_mm}));
}

int32_t SurfaceIndex::nearest_vertex(const Snapshot& s, const Vec3& p_mm, bool unmarked_only) const {
  const Vec3f p = p_mm.cast<float>();
  int32_t best = -1;
  float best2 = 1e30f;
  for (const int32_t v : of(s).vertex) {
    const float d2 = (float_at(s, v) - p).squaredNorm();
    if (d2 < best2 && !(unmarked_only && mark_.contains(v))) best2 = d2, best = v;
  }
  return best;
}

void SurfaceIndex::mark_sheet(const Snapshot& s, const SkinTouch& middle) {
  const SurfaceView& view = s.topology->view;
  const GroundIndex& ground = of(s);
  size_t next = mark_.size();
  for (const int32_t v : view.tri[size_t(middle.triangle)]) mark_.insert(v);
  for (; next < mark_.size(); ++next) {
    const int32_t v = mark_[next];
    if ((view.X_mm[size_t(v)] - middle.X_mm).norm() > kSheetRadius_mm) continue;
    for (const int32_t t : ground.around(v))
      for (const int32_t w : view.tri[size_t(t)]) mark_.insert(w);
  }
}

bool SurfaceIndex::marked(const Snapshot& s, int32_t triangle) const {
  const Tri& k = s.topology->view.tri[size_t(triangle)];
  return std::any_of(k.begin(), k.end(), [&](int32_t v) { return mark_.contains(v); });
}

size_t SurfaceIndex::sheets_near(const Snapshot& s, const Vec3& p_mm, double among_mm, std::span<SkinTouch> out) {
  size_t n = 0;
  while (n < out.size()) {
    const int32_t v = nearest_vertex(s, p_mm, n > 0);
    if (v < 0) break;
    out[n] = touch(s, walk_from_vertex(s, p_mm, v));
    // The walk may run back over the border of a sheet that is known: then this was a part of it.
    if (n > 0 && (marked(s, out[n].triangle) || out[n].distance_mm > out[0].distance_mm + among_mm)) break;
    mark_sheet(s, out[n]);
    ++n;
  }
  mark_.clear();
  return n;
}

SkinTouch SurfaceIndex::closest_apart(const Snapshot& s, const Vec3& p_mm, const SkinTouch& other, double reach_mm,
                                      bool exactly) {
  if (other.triangle < 0) return {};
  mark_sheet(s, other);
  SkinTouch found;
  if (const int32_t v = nearest_vertex(s, p_mm, true); v >= 0) {
    found = touch(s, walk_from_vertex(s, p_mm, v));
    if (found.distance_mm > reach_mm || marked(s, found.triangle)) found = {};
  }
  if (exactly) {
    const double within = found.triangle >= 0 ? found.distance_mm : reach_mm;
    if (const Place p = nearer(s, p_mm, {found.triangle, found.bary, within * within}); p.triangle >= 0)
      found = touch(s, p);
  }
  mark_.clear();
  return found;
}

bool SurfaceIndex::edge_between(const Snapshot& s, const SkinTouch& from, const SkinTouch& to) {
  const SurfaceView& view = s.topology->view;
  const Vec3 way = to.X_mm - from.X_mm, up = (from.N + to.N).normalized();
  const Vec3 across = up.cross(way);
  if (from.triangle < 0 || to.triangle < 0 || across.squaredNorm() <= 0) return false;
  Eigen::Matrix<double, 2, 3> plane;
  plane << way.normalized().transpose(), across.normalized().transpose();
  // What lies further above or below than half the way is of a fold behind them. A place on an edge is not beyond it.
  constexpr double kOnEdge_mm = 0.05;
  const double length = way.norm(), high = std::max(0.5 * length, 1.0);
  const Vec2 first(kOnEdge_mm, 0), last(length - kOnEdge_mm, 0);
  if (length <= 2 * kOnEdge_mm) return false;
  for (size_t t = 0; t < view.rim.size(); ++t)
    for (size_t k = 0; view.rim[t] != 0 && k < 3; ++k) {
      if (!(view.rim[t] >> k & 1)) continue;
      const Vec3 a = view.X_mm[size_t(view.tri[t][k])] - from.X_mm,
                 b = view.X_mm[size_t(view.tri[t][(k + 1) % 3])] - from.X_mm;
      if (std::abs((a + b).dot(up)) > 2 * high) continue;
      if (meet_segments(first, last, plane * a, plane * b)) return true;
    }
  return false;
}

SurfaceIndex::Place SurfaceIndex::walk(const Snapshot& s, const Vec3& p_mm, int32_t triangle) const {
  const SharedArray<Tri>& tri = s.topology->view.tri;
  const GroundIndex& ground = of(s);
  Place best;
  auto look_at = [&](int32_t t) {
    const Tri& k = tri[size_t(t)];
    const TrianglePoint c = closest_on_triangle(p_mm, float_at(s, k[0]).cast<double>(),
                                                float_at(s, k[1]).cast<double>(), float_at(s, k[2]).cast<double>());
    const double d2 = (c.point - p_mm).squaredNorm();
    // Equal distances (a shared edge or corner) go to the lower number, so that the way here does not matter.
    if (d2 < best.distance2 || (d2 == best.distance2 && t < best.triangle)) best = {t, c.bary, d2};
  };
  look_at(triangle);
  for (int step = 0, from = -1; step < kMaxWalk && best.triangle >= 0 && best.triangle != from; ++step) {
    from = best.triangle;
    for (const int32_t v : tri[size_t(from)])
      for (const int32_t t : ground.around(v)) look_at(t);
  }
  return best;
}

SurfaceIndex::Place SurfaceIndex::walk_from_vertex(const Snapshot& s, const Vec3& p_mm, int32_t vertex) const {
  return walk(s, p_mm, of(s).around(vertex).front());
}

SkinTouch SurfaceIndex::closest(const Snapshot& s, const Vec3& p_mm, int32_t hint) const {
  if (hint >= 0) return touch(s, walk(s, p_mm, hint));
  const int32_t v = nearest_vertex(s, p_mm, false);
  if (v < 0) return {};
  return touch(s, walk_from_vertex(s, p_mm, v));
}

int SurfaceIndex::facets_around(const Snapshot& s, const SkinTouch& place, double reach_mm,
                                std::span<std::array<Vec3, 3>> out) const {
  constexpr size_t kMost = 128;
  std::array<int32_t, kMost> found;
  size_t n = 0;
  const size_t most = std::min(kMost, out.size());
  if (place.triangle < 0 || most == 0) return 0;
  const SharedArray<Tri>& tri = s.topology->view.tri;
  const GroundIndex& ground = of(s);
  found[n++] = place.triangle;
  for (size_t next = 0; next < n && n < most; ++next)
    for (const int32_t v : tri[size_t(found[next])]) {
      if ((float_at(s, v).cast<double>() - place.x_mm).norm() > reach_mm) continue;
      for (const int32_t t : ground.around(v)) {
        if (n == most) break;
        if (std::find(found.begin(), found.begin() + long(n), t) == found.begin() + long(n)) found[n++] = t;
      }
    }
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 0; k < 3; ++k) out[i][k] = float_at(s, tri[size_t(found[i])][k]).cast<double>();
  return int(n);
}

}  // namespace limberg
