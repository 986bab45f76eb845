#include "sim/body/skin.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "sim/base/elementary.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

Vec3 face_normal(const TriMesh& m, int32_t t) {
  const Tri& c = m.tri[size_t(t)];
  return area_vector2(m.X_mm[size_t(c[0])], m.X_mm[size_t(c[1])], m.X_mm[size_t(c[2])]).normalized();
}

}  // namespace

Skin::Skin(std::shared_ptr<const Body> body)
    : body_(std::move(body)), surface_(body_->surface.X_mm, body_->surface.tri) {
  const TriMesh& m = body_->surface;
  std::vector<int32_t> skin;
  for (size_t t = 0; t < m.tri.size(); ++t)
    if (m.tag.empty() || m.tag[t] == SurfaceTag::skin) skin.push_back(int32_t(t));
  any_ = !skin.empty();
  if (any_) skin_ = Bvh(m.X_mm, m.tri, skin);

  corner_normal_.assign(m.X_mm.size(), Vec3::Zero());
  edge_normal_.assign(m.tri.size(), {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()});
  struct Side {
    int32_t a, b, triangle;
    int k;
  };
  std::vector<Side> sides;
  sides.reserve(3 * skin.size());
  for (int32_t t : skin) {
    const Tri& c = m.tri[size_t(t)];
    const Vec3 n = face_normal(m, t);
    area_mm2_ += 0.5 * area_vector2(m.X_mm[size_t(c[0])], m.X_mm[size_t(c[1])], m.X_mm[size_t(c[2])]).norm();
    for (int k = 0; k < 3; ++k) {
      const int32_t v = c[size_t(k)], next = c[size_t((k + 1) % 3)], last = c[size_t((k + 2) % 3)];
      const Vec3 e = m.X_mm[size_t(next)] - m.X_mm[size_t(v)], f = m.X_mm[size_t(last)] - m.X_mm[size_t(v)];
      corner_normal_[size_t(v)] += elementary::atan2(e.cross(f).norm(), e.dot(f)) * n;
      sides.push_back({std::min(v, next), std::max(v, next), t, k});
    }
  }
  for (Vec3& n : corner_normal_)
    if (n.squaredNorm() > 0) n.normalize();
  std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
    return std::tie(p.a, p.b, p.triangle) < std::tie(q.a, q.b, q.triangle);
  });
  for (size_t i = 0; i < sides.size();) {
    size_t j = i;
    Vec3 sum = Vec3::Zero();
    for (; j < sides.size() && sides[j].a == sides[i].a && sides[j].b == sides[i].b; ++j)
      sum += face_normal(m, sides[j].triangle);
    for (; i < j; ++i) edge_normal_[size_t(sides[i].triangle)][size_t(sides[i].k)] = sum;
  }
  for (const Vec3& X : m.X_mm) reach_mm_ = std::max(reach_mm_, (X - body_->chart_origin_mm).norm());
}

std::optional<SkinHit> Skin::at(const ChartPoint& p) const {
  if (!any_ || !p.allFinite()) return std::nullopt;
  const Body& b = *body_;
  const Vec3 n = b.chart_normal();
  const Vec3 o = b.chart_origin_mm + p.x() * b.chart_e1 + p.y() * b.chart_e2 + (2 * reach_mm_ + 1) * n;
  std::array<Bvh::LineHit, 16> hits;
  const int count = std::min<int>(surface_.line(o, -n, 0, std::numeric_limits<double>::max(), hits), int(hits.size()));
  // Several triangles can share the outermost point (an edge, a corner): skin wins there.
  for (int i = 0; i < count && hits[size_t(i)].t <= hits[0].t + 1e-9; ++i) {
    const auto& h = hits[size_t(i)];
    const bool skin = b.surface.tag.empty() || b.surface.tag[size_t(h.triangle)] == SurfaceTag::skin;
    if (!skin || !h.from_outside) continue;
    const Tri& c = b.surface.tri[size_t(h.triangle)];
    Vec3 X = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) X += h.bary[k] * b.surface.X_mm[size_t(c[k])];
    return SkinHit{X, face_normal(b.surface, h.triangle), h.triangle};
  }
  return std::nullopt;
}

SkinHit Skin::nearest(const Vec3& X) const {
  if (!any_) return {};
  const auto c = skin_.closest(X);
  return {c.point_mm, face_normal(body_->surface, c.triangle), c.triangle};
}

Vec3 Skin::side_normal(const Bvh::Closest& c) const {
  const Tri& t = body_->surface.tri[size_t(c.triangle)];
  const int zeros = int(c.bary[0] == 0) + int(c.bary[1] == 0) + int(c.bary[2] == 0);
  if (zeros == 2)
    for (size_t k = 0; k < 3; ++k)
      if (c.bary[k] != 0) return corner_normal_[size_t(t[k])];
  if (zeros == 1)
    for (size_t k = 0; k < 3; ++k)
      if (c.bary[k] == 0) return edge_normal_[size_t(c.triangle)][(k + 1) % 3];
  return face_normal(body_->surface, c.triangle);
}

double Skin::depth_mm(const Vec3& X) const {
  if (!any_) return std::numeric_limits<double>::infinity();
  Bvh::Closest near;
  return depth_mm(X, near);
}

double Skin::depth_mm(const Vec3& X, Bvh::Closest& near) const {
  if (!any_) return std::numeric_limits<double>::infinity();
  // The last answer's point is skin too: nothing farther away can be nearest.
  const double bound =
      near.triangle >= 0 ? (X - near.point_mm).norm() * (1 + 1e-12) + 1e-12 : std::numeric_limits<double>::infinity();
  near = skin_.closest(X, bound);
  return (X - near.point_mm).dot(side_normal(near)) > 0 ? -near.distance_mm : near.distance_mm;
}

int Skin::layer_at(double depth_mm) const {
  const auto& layers = body_->layers;
  double end = 0;
  for (size_t i = 0; i + 1 < layers.size(); ++i) {
    end += layers[i].thickness_mm;
    if (depth_mm < end) return int(i);
  }
  return std::max(0, int(layers.size()) - 1);
}

Skin::Frame Skin::frame(const Vec3& X) const {
  Frame f;
  if (any_) {
    const auto c = skin_.closest(X);
    const Tri& t = body_->surface.tri[size_t(c.triangle)];
    Vec3 n = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) n += c.bary[k] * corner_normal_[size_t(t[k])];
    f.normal = n.norm() > 1e-6 ? n.normalized() : face_normal(body_->surface, c.triangle);
  }
  // Where the tension lines stand upright on the skin, any direction in its plane is as good.
  for (const Vec3& d : {body_->tension_direction, body_->chart_e1, body_->chart_e2}) {
    const Vec3 flat = d - d.dot(f.normal) * f.normal;
    if (flat.norm() > 1e-3) {
      f.along = flat.normalized();
      break;
    }
  }
  f.across = f.normal.cross(f.along);
  return f;
}

}  // namespace limberg
