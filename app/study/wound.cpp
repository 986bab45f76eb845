#include "app/study/wound.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace limberg::study {

std::vector<Layer> skin_on_fat(double thickness_mm, double prestretch_percent) {
  constexpr double kSkin_mm = 1.5, kFatShare = 0.8;
  Material skin, fat;
  skin.young_kPa = 60, fat.young_kPa = 15;
  skin.poisson = fat.poisson = 0.45;
  skin.prestretch_along = skin.prestretch_across = 1 + prestretch_percent / 100;
  fat.prestretch_along = fat.prestretch_across = 1 + kFatShare * prestretch_percent / 100;
  return {{"skin", kSkin_mm, skin}, {"fat", thickness_mm - kSkin_mm, fat}};
}

namespace {

/// Calls visit(t, a, b) for every edge a -> b of a skin triangle t whose other side is a wall.
template <class Visit>
void for_rim(const SurfaceView& v, Visit visit) {
  std::map<std::pair<int32_t, int32_t>, int32_t> of_edge;
  for (size_t t = 0; t < v.tri.size(); ++t)
    if (v.kind[t] == FaceKind::wall)
      for (size_t k = 0; k < 3; ++k) of_edge[{v.tri[t][k], v.tri[t][(k + 1) % 3]}] = int32_t(t);
  for (size_t t = 0; t < v.tri.size(); ++t) {
    if (v.kind[t] != FaceKind::skin) continue;
    for (size_t k = 0; k < 3; ++k)
      if (of_edge.contains({v.tri[t][(k + 1) % 3], v.tri[t][k]})) visit(t, v.tri[t][k], v.tri[t][(k + 1) % 3]);
  }
}

double area(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * (b - a).cross(c - a).norm(); }

}  // namespace

StraightWound::StraightWound(const Snapshot& s) {
  const SurfaceView& v = s.topology->view;
  for_rim(v, [&](size_t, int32_t a, int32_t b) {
    Edge e{{v.X_mm[size_t(a)], s.x_mm[size_t(a)].cast<double>()},
           {v.X_mm[size_t(b)], s.x_mm[size_t(b)].cast<double>()}};
    // The skin lies to the left of its edges: what runs towards +x is the edge of the bank at y > 0.
    const bool left = e.a.X_mm.x() < e.b.X_mm.x();
    if (!left) std::swap(e.a, e.b);
    edge_[left ? 0 : 1].push_back(e);
  });
}

std::optional<Bank> StraightWound::at(const std::vector<Edge>& edges, double x) {
  for (const Edge& e : edges) {
    if (x < e.a.X_mm.x() || x > e.b.X_mm.x()) continue;
    const double l = e.b.X_mm.x() - e.a.X_mm.x(), t = l > 0 ? (x - e.a.X_mm.x()) / l : 0;
    return Bank{(1 - t) * e.a.X_mm + t * e.b.X_mm, (1 - t) * e.a.x_mm + t * e.b.x_mm};
  }
  return std::nullopt;
}

double StraightWound::gape_mm(double x) const {
  const auto l = left(x), r = right(x);
  return l && r ? (l->x_mm - r->x_mm).norm() : 0;
}

SkinArea central_skin(const Snapshot& s) {
  const SurfaceView& v = s.topology->view;
  const std::vector<int32_t> component_of = surface_components(v);
  double best = 1e300;
  int32_t component = -1;
  for (size_t t = 0; t < v.tri.size(); ++t) {
    if (v.kind[t] != FaceKind::skin) continue;
    Vec3 c = Vec3::Zero();
    for (const int32_t i : v.tri[t]) c += v.X_mm[size_t(i)] / 3;
    if (const double d = (c - s.topology->body->chart_origin_mm).norm(); d < best)
      best = d, component = component_of[t];
  }
  SkinArea out;
  for (size_t t = 0; t < v.tri.size(); ++t) {
    if (v.kind[t] != FaceKind::skin || component_of[t] != component) continue;
    const auto X = [&](size_t k) { return v.X_mm[size_t(v.tri[t][k])]; };
    const auto x = [&](size_t k) { return Vec3(s.x_mm[size_t(v.tri[t][k])].cast<double>()); };
    out.rest_mm2 += area(X(0), X(1), X(2));
    out.now_mm2 += area(x(0), x(1), x(2));
  }
  return out;
}

Hole central_hole(const Snapshot& s) {
  const SurfaceView& v = s.topology->view;
  const std::vector<int32_t> component_of = surface_components(v);
  std::map<int32_t, size_t> size;
  for (const int32_t c : component_of) ++size[c];
  int32_t largest = size.empty() ? -1 : size.begin()->first;
  for (const auto& [c, n] : size)
    if (n > size[largest]) largest = c;
  Hole out;
  Vec2 lo = Vec2::Constant(1e300), hi = -lo;
  const auto cross = [](const auto& a, const auto& b) {
    return double(a.x()) * double(b.y()) - double(a.y()) * double(b.x());
  };
  for_rim(v, [&](size_t t, int32_t a, int32_t b) {
    if (component_of[t] != largest) return;
    // The skin lies to the left of its edges: around a hole they run clockwise.
    out.rest_mm2 -= 0.5 * cross(v.X_mm[size_t(a)], v.X_mm[size_t(b)]);
    out.now_mm2 -= 0.5 * cross(s.x_mm[size_t(a)], s.x_mm[size_t(b)]);
    const Vec2 p = s.x_mm[size_t(a)].head<2>().cast<double>();
    lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  });
  if (out.rest_mm2 != 0) out.extent_mm = hi - lo;
  return out;
}

}  // namespace limberg::study
