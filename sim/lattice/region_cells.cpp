#include "sim/lattice/region_cells.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace limberg {
namespace {

// Depth and way down between the samples of a cell: linear along each axis.
Region::Below below_at(const CellSamples& samples, const Vec3& at) {
  std::array<int, 3> low{};
  Vec3 t;
  for (int a = 0; a < 3; ++a) {
    const double x = at[a] * kSplit;
    low[size_t(a)] = std::clamp(int(x), 0, kSplit - 1);
    t[a] = x - low[size_t(a)];
  }
  Region::Below out;
  out.depth_mm = 0, out.down.setZero();
  for (int k = 0; k < 8; ++k) {
    const int i = low[0] + (k & 1), j = low[1] + (k >> 1 & 1), l = low[2] + (k >> 2 & 1);
    const Skin::Place& p = samples[size_t((l * (kSplit + 1) + j) * (kSplit + 1) + i)];
    const double w = (k & 1 ? t[0] : 1 - t[0]) * (k >> 1 & 1 ? t[1] : 1 - t[1]) * (k >> 2 & 1 ? t[2] : 1 - t[2]);
    out.depth_mm += w * std::min(p.depth_mm, 1e30), out.down += w * p.down, out.thicker_mm += w * p.thicker_mm;
  }
  return out;
}

// The skin's, or where the region has fibres of its own way: along these, the normal as near to the skin's as can be.
StretchFrame frame_in(const Region& region, const Vec3& X, const StretchFrame& skin) {
  const std::optional<Vec3> along = region.direction(X);
  if (!along) return skin;
  StretchFrame f;
  f.along = *along;
  f.normal = skin.normal - skin.normal.dot(f.along) * f.along;
  if (f.normal.norm() < 1e-3) f.normal = skin.along - skin.along.dot(f.along) * f.along;  // upright fibres
  f.normal.normalize();
  f.across = f.normal.cross(f.along);
  return f;
}

}  // namespace

RegionCells::RegionCells(const Skin& skin, std::span<const double> end_mm)
    : skin_(skin), border_mm_(end_mm.begin(), end_mm.end()) {
  for (const auto& r : skin.body().regions)
    for (const double d : {r->from_mm(), r->to_mm()})
      if (std::isfinite(d)) border_mm_.push_back(d);
  std::sort(border_mm_.begin(), border_mm_.end());
  border_mm_.erase(std::unique(border_mm_.begin(), border_mm_.end()), border_mm_.end());
  for (size_t i = 0; i <= border_mm_.size(); ++i) {
    const double below = i == 0 ? -INFINITY : border_mm_[i - 1];
    layer_.push_back(int(std::upper_bound(end_mm.begin(), end_mm.end(), below) - end_mm.begin()));
  }
}

bool RegionCells::reach(const Vec3& X, const Skin::Place& place, double reach_mm) const {
  const auto& regions = skin_.body().regions;
  return std::any_of(regions.begin(), regions.end(), [&](const auto& r) {
    return r->reaches(X, {place.depth_mm, place.down, place.thicker_mm}, reach_mm);
  });
}

std::vector<LayerPoint> RegionCells::points(const Vec3& low, const Vec3& h, const CellSamples& samples) const {
  const auto& regions = skin_.body().regions;
  const size_t layers = skin_.body().layers.size();
  const double spacing = h.mean() / (2 * kSplit);
  std::vector<LayerPoint> out;
  for (LayerPoint p : CellCutter(h, border_mm_).fine_points(samples)) {
    const size_t between = size_t(p.layer);
    const double above = between == 0 ? -INFINITY : border_mm_[between - 1],
                 under = between == border_mm_.size() ? INFINITY : border_mm_[between];
    p.layer = layer_[between], p.matter = size_t(p.layer);
    const Vec3 X = low + h.cwiseProduct(p.at);
    const Region::Below below = below_at(samples, p.at);
    double left = 1;
    for (size_t r = regions.size(); r-- > 0 && left > 0;) {
      if (!(regions[r]->from_mm() <= above && under <= regions[r]->to_mm())) continue;
      const double share = std::clamp(0.5 + regions[r]->inside_beside_mm(X, below) / spacing, 0.0, 1.0);
      if (!(share > 0)) continue;
      LayerPoint part = p;
      part.matter = layers + r, part.volume_mm3 *= left * share;
      out.push_back(part);
      left *= 1 - share;
    }
    if (!(left > 0)) continue;
    p.volume_mm3 *= left;
    out.push_back(p);
  }
  return out;
}

size_t RegionCells::matter(const Vec3& X, const Skin::Place& place, int layer) const {
  const auto region = region_at(skin_.body(), X, {place.depth_mm, place.down, place.thicker_mm});
  return region ? skin_.body().layers.size() + *region : size_t(layer);
}

std::vector<StretchFrame> RegionCells::frames(const Vec3& centre, const StretchFrame& skin) const {
  const Body& body = skin_.body();
  std::vector<StretchFrame> out(body.layers.size(), skin);
  for (const auto& r : body.regions) out.push_back(frame_in(*r, centre, skin));
  return out;
}

std::vector<CellPart> parts_of(std::span<const LayerPoint> points, std::span<const StretchFrame> frames) {
  std::map<std::pair<int, size_t>, size_t> at;
  std::vector<CellPart> out;
  for (const LayerPoint& p : points) {
    const auto [it, is_new] = at.try_emplace({p.layer, p.matter}, out.size());
    if (is_new) out.push_back({p.layer, p.matter, frames[p.matter], {}});
    out[it->second].moments.add_point(p.at, p.volume_mm3, p.edge);
  }
  return out;
}

MatterAt matter_at(const Skin& skin, const Vec3& X, int layer, Skin::Near& near) {
  const Body& body = skin.body();
  const Skin::Frame f = skin.frame(X);
  const StretchFrame of_skin{f.along, f.across, f.normal};
  if (!body.regions.empty()) {
    const Skin::Place place = skin.place(X, near);
    if (const auto r = region_at(body, X, {place.depth_mm, place.down, place.thicker_mm}))
      return {body.layers.size() + *r, &body.regions[*r]->material(), frame_in(*body.regions[*r], X, of_skin)};
  }
  return {size_t(layer), &body.layers[size_t(layer)].material, of_skin};
}

}  // namespace limberg
