#include "sim/patient/rest_index.h"

#include <algorithm>
#include <numeric>
#include <unordered_set>

#include "sim/base/number_set.h"
#include "sim/cutting/arrangement/radix_sort.h"
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

RestIndex::Mesh::Mesh(const SurfaceView& v)
    : X_mm(v.X_mm), tri(v.tri), kind(v.kind), sided_face(v.sided_face), origin(v.origin), rim(v.rim) {}

RestIndex::RestIndex(const SurfaceView& view, size_t body_triangles) : view_(view) { find_all(body_triangles); }

void RestIndex::find_all(size_t body_triangles) {
  std::vector<int32_t> order(view_.tri.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int32_t a, int32_t b) { return name(a) < name(b); });
  std::vector<int32_t> first(body_triangles + 1, 0);
  for (size_t t = 0; t < order.size(); ++t)
    if (of_body(view_.kind[t])) ++first[size_t(view_.origin[t]) + 1];
  for (size_t i = 0; i < body_triangles; ++i) first[i + 1] += first[i];
  std::vector<int32_t> list(size_t(first.back())), next(first.begin(), first.end() - 1);
  for (int32_t t : order)
    if (of_body(view_.kind[size_t(t)])) list[size_t(next[size_t(view_.origin[size_t(t)])]++)] = t;
  by_origin_ = ShortLists(body_triangles);
  for (size_t i = 0; i < body_triangles; ++i)
    by_origin_.set(i, std::span(list).subspan(size_t(first[i]), size_t(first[i + 1] - first[i])));

  // The rim: edges of skin whose other side is wall.
  rim_.clear();
  std::unordered_set<uint64_t> wall_edges;
  std::vector<uint8_t> on_wall(view_.X_mm.size(), 0);
  for (size_t t = 0; t < order.size(); ++t)
    if (view_.kind[t] == FaceKind::wall)
      for (size_t k = 0; k < 3; ++k) {
        wall_edges.emplace(edge_key(view_.tri[t][k], view_.tri[t][(k + 1) % 3]));
        on_wall[size_t(view_.tri[t][k])] = 1;
      }
  for (int32_t t : order) {
    if (view_.kind[size_t(t)] != FaceKind::skin) continue;
    for (int k = 0; k < 3; ++k) {
      const int32_t a = view_.tri[size_t(t)][size_t(k)], b = view_.tri[size_t(t)][size_t((k + 1) % 3)];
      if (on_wall[size_t(a)] && on_wall[size_t(b)] && wall_edges.count(edge_key(b, a))) rim_.push_back({t, k});
    }
  }
}

RestIndex::RestIndex(const SurfaceView& view, const RestIndex& before, const ViewChange& change) : view_(view) {
  if (change.whole) {
    find_all(before.by_origin_.keys());
    return;
  }
  by_origin_ = before.by_origin_;
  NumberSet changed(std::max(view_.tri.size(), before.view_.tri.size())),
      origins(by_origin_.keys());  // whose triangles are others
  struct OfOrigin {
    int32_t origin, triangle;
  };
  struct NamedEdge {
    uint64_t key;  // orders rim edges
    RimEdge edge;
  };
  const auto key_of = [&](const RimEdge& e) { return uint64_t(name(e.triangle)) * 4 + uint64_t(e.corner); };
  std::vector<OfOrigin> come, room;
  std::vector<NamedEdge> fresh, edge_room;
  uint64_t all_keys = 0;
  for (int32_t t : change.triangles) {
    changed.add(t);
    const bool was = size_t(t) < before.view_.tri.size(), body = of_body(view_.kind[size_t(t)]);
    if (!was || before.view_.sided_face[size_t(t)] != view_.sided_face[size_t(t)]) {
      if (was && of_body(before.view_.kind[size_t(t)])) origins.add(before.view_.origin[size_t(t)]);
      if (body) origins.add(view_.origin[size_t(t)]);
    }
    if (body) come.push_back({view_.origin[size_t(t)], t});
    if (const uint8_t rim = view_.rim[size_t(t)])
      for (int k = 0; k < 3; ++k)
        if (rim >> k & 1) {
          fresh.push_back({key_of({t, k}), {t, k}});
          all_keys |= fresh.back().key;
        }
  }
  radix_sort(come, room, bits_of(by_origin_.keys()), [](const OfOrigin& c) { return uint64_t(c.origin); });
  std::vector<int32_t> list;
  size_t next = 0;
  for (int32_t o : origins.ascending()) {
    list.clear();
    for (int32_t i = 0; i < before.by_origin_.count(size_t(o)); ++i)
      if (const int32_t t = before.by_origin_.at(size_t(o), i); !changed.has(t)) list.push_back(t);
    while (next < come.size() && come[next].origin < o) ++next;
    for (; next < come.size() && come[next].origin == o; ++next) list.push_back(come[next].triangle);
    std::sort(list.begin(), list.end(), [&](int32_t a, int32_t b) { return name(a) < name(b); });
    by_origin_.set(size_t(o), list);
  }
  radix_sort(fresh, edge_room, bits_of(all_keys), [](const NamedEdge& e) { return e.key; });
  rim_.reserve(before.rim_.size() + fresh.size());
  auto add = fresh.begin();
  for (const RimEdge& e : before.rim_) {
    if (changed.has(e.triangle)) continue;
    for (const uint64_t key = key_of(e); add != fresh.end() && add->key < key; ++add) rim_.push_back(add->edge);
    rim_.push_back(e);
  }
  for (; add != fresh.end(); ++add) rim_.push_back(add->edge);
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
  if (origin < 0 || size_t(origin) >= by_origin_.keys()) return std::nullopt;
  std::optional<SurfacePoint> best;
  double best2 = slack_mm * slack_mm;
  for (int32_t i = 0; i < by_origin_.count(size_t(origin)); ++i) {
    double d2;
    const SurfacePoint p = closest_in(by_origin_.at(size_t(origin), i), X_mm, d2);
    if (d2 <= best2 && (!best || d2 < best2)) best2 = d2, best = p;
  }
  return best;
}

std::optional<SurfacePoint> RestIndex::nearest_skin(const Vec3& X_mm, double reach_mm) const {
  std::optional<SurfacePoint> best;
  double best2 = reach_mm * reach_mm;
  for (size_t t = 0; t < view_.tri.size(); ++t) {
    if (view_.kind[t] != FaceKind::skin) continue;
    double d2;
    const SurfacePoint p = closest_in(int32_t(t), X_mm, d2);
    if (d2 < best2 || (d2 == best2 && (!best || name(int32_t(t)) < name(best->triangle)))) best2 = d2, best = p;
  }
  return best;
}

std::optional<SurfacePoint> RestIndex::snap_to_rim(const SurfacePoint& p, double reach_mm) const {
  const Vec3 X = rest_mm(p);
  std::optional<SurfacePoint> best;
  double best2 = reach_mm * reach_mm;
  for (const RimEdge& e : rim_) {
    const Vec3 a = corner(e.triangle, e.corner), b = corner(e.triangle, e.corner + 1),
               c = corner(e.triangle, e.corner + 2);
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
