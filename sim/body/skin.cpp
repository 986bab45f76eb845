#include "sim/body/skin.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/body/tension_lines.h"
#include "sim/geometry/triangle.h"

namespace limberg {
Skin::Skin(std::shared_ptr<const Body> body) : body_(std::move(body)) {
  const TriMesh& m = body_->surface;
  std::vector<int32_t> skin;
  for (int32_t t = 0; t < int32_t(m.tri.size()); ++t)
    if (m.tag.empty() || m.tag[size_t(t)] == SurfaceTag::skin) skin.push_back(t);
  surface_ = SidedPatch(m);
  any_ = !skin.empty();
  if (any_) skin_ = SidedPatch(m, skin);
  for (int32_t t : skin) {
    const Tri& c = m.tri[size_t(t)];
    area_mm2_ += 0.5 * area_vector2(m.X_mm[size_t(c[0])], m.X_mm[size_t(c[1])], m.X_mm[size_t(c[2])]).norm();
  }
  for (const Vec3& X : m.X_mm) reach_mm_ = std::max(reach_mm_, (X - body_->chart_origin_mm).norm());
  const bool is_even = std::all_of(body_->thickness_mm.begin(), body_->thickness_mm.end(),
                                   [](const std::vector<float>& of) { return of.empty(); });
  if (is_even || !any_) return;
  const size_t borders = body_->layers.size() - 1;
  least_end_mm_.assign(borders, std::numeric_limits<double>::infinity()), most_end_mm_.assign(borders, 0);
  for (int32_t t : skin)
    for (int32_t v : m.tri[size_t(t)]) {
      double end = 0;
      for (size_t l = 0; l < borders; ++l) {
        end += body_->layer_thickness_mm(l, v);
        least_end_mm_[l] = std::min(least_end_mm_[l], end), most_end_mm_[l] = std::max(most_end_mm_[l], end);
      }
    }
}

std::optional<SkinHit> Skin::at(const ChartPoint& p) const {
  if (!any_ || !p.allFinite()) return std::nullopt;
  const Body& b = *body_;
  const Vec3 n = b.chart_normal();
  const Vec3 o = b.chart_origin_mm + p.x() * b.chart_e1 + p.y() * b.chart_e2 + (2 * reach_mm_ + 1) * n;
  std::array<Bvh::LineHit, 16> hits;
  const int count =
      std::min<int>(surface_.bvh().line(o, -n, 0, std::numeric_limits<double>::max(), hits), int(hits.size()));
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

std::optional<SkinHit> Skin::at(const ChartPoint& p, const SkinView& view) const {
  if (!any_ || !p.allFinite()) return std::nullopt;
  const Vec3 n = view.chart.normal();
  const double far = 2 * (reach_mm_ + (view.chart.origin_mm - body_->chart_origin_mm).norm()) + 1;
  const double wanted = view.height_mm(p);
  std::optional<SkinHit> best;
  double least = std::numeric_limits<double>::infinity();
  for (const Bvh::LineHit& h : skin_.bvh().line(view.chart.to_space(p, far), -n, 0, 2 * far)) {
    const double off = std::abs(far - h.t - wanted);
    if (!h.from_outside || off >= least) continue;
    least = off;
    best = SkinHit{view.chart.to_space(p, far - h.t), face_normal(body_->surface, h.triangle), h.triangle};
  }
  return best;
}

SkinHit Skin::nearest(const Vec3& X) const {
  if (!any_) return {};
  const auto c = skin_.bvh().closest(X);
  return {c.point_mm, face_normal(body_->surface, c.triangle), c.triangle};
}

double Skin::depth_mm(const Vec3& X) const {
  if (!any_) return std::numeric_limits<double>::infinity();
  Bvh::Closest near;
  return depth_mm(X, near);
}

double Skin::depth_mm(const Vec3& X, Bvh::Closest& near) const {
  if (!any_) return std::numeric_limits<double>::infinity();
  return skin_.depth_mm(X, near);
}

Skin::Place Skin::place(const Vec3& X, Near& near) const {
  Place p;
  p.inside_mm = surface_.depth_mm(X, near.surface);
  const auto& tag = body_->surface.tag;
  const Bvh::Closest* from = &near.surface;
  if (!any_) {
    p.depth_mm = std::numeric_limits<double>::infinity();
    return p;
  }
  if (tag.empty() || tag[size_t(near.surface.triangle)] == SurfaceTag::skin) {
    p.depth_mm = p.inside_mm;
  } else {
    p.depth_mm = p.inside_mm > 0 ? std::abs(skin_.depth_mm(X, near.skin)) : skin_.depth_of_plane_mm(X, near.skin);
    from = &near.skin;
  }
  p.down = -(from == &near.surface ? surface_ : skin_).side_normal(*from).normalized();
  if (!even()) p.thicker_mm = p.depth_mm - in_layers_mm(p.depth_mm, *from);
  return p;
}

double Skin::in_layers_mm(double depth_mm, const Bvh::Closest& near) const {
  if (even() || near.triangle < 0) return depth_mm;
  const Tri& corners = body_->surface.tri[size_t(near.triangle)];
  double top = 0, counted = 0;  // where a layer begins, and where Body::layers says that it does
  for (size_t l = 0; l + 1 < body_->layers.size(); ++l) {
    const double usual = body_->layers[l].thickness_mm;
    double thick = 0;
    for (size_t k = 0; k < 3; ++k) thick += near.bary[k] * body_->layer_thickness_mm(l, corners[k]);
    const double below = depth_mm - top;
    if (below < thick) {
      const double third = std::min(thick, usual) / 3;
      if (l == 0 || below > thick - third) return counted + usual - (thick - below);
      if (below < third) return counted + below;
      return counted + third + (below - third) * (usual - 2 * third) / (thick - 2 * third);
    }
    top += thick, counted += usual;
  }
  return counted + (depth_mm - top);
}

int Skin::layer_at(double in_layers_mm) const {
  const auto& layers = body_->layers;
  double end = 0;
  for (size_t i = 0; i + 1 < layers.size(); ++i) {
    end += layers[i].thickness_mm;
    if (in_layers_mm < end) return int(i);
  }
  return std::max(0, int(layers.size()) - 1);
}

std::pair<int, int> Skin::layers_within(double depth_mm, double reach_mm) const {
  if (even()) return {layer_at(depth_mm - reach_mm), layer_at(depth_mm + reach_mm)};
  const auto first_below = [](const std::vector<double>& end, double depth) {
    return int(std::find_if(end.begin(), end.end(), [&](double e) { return depth < e; }) - end.begin());
  };
  return {first_below(most_end_mm_, depth_mm - reach_mm), first_below(least_end_mm_, depth_mm + reach_mm)};
}

Skin::Frame Skin::frame(const Vec3& X) const {
  Frame f;
  Vec3 lines = body_->tension_direction;
  if (any_) {
    const auto c = skin_.bvh().closest(X);
    const Tri& t = body_->surface.tri[size_t(c.triangle)];
    Vec3 n = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) n += c.bary[k] * skin_.corner_normal(t[k]);
    f.normal = n.norm() > 1e-6 ? n.normalized() : face_normal(body_->surface, c.triangle);
    if (!body_->tension.empty()) lines = tension_along(*body_, c.triangle, c.bary);
  }
  // Where the tension lines stand upright on the skin, any direction in its plane is as good.
  for (const Vec3& d : {lines, body_->tension_direction, body_->chart_e1, body_->chart_e2}) {
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
