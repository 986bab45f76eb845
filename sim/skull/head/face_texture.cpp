#include "sim/skull/head/face_texture.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace limberg {
namespace {

using Corner = std::pair<int32_t, std::array<float, 2>>;  // a vertex where it lies in the picture

/// Per triangle: the number of its chart.
std::vector<int32_t> charts(const ColouredSurface& s) {
  std::vector<int32_t> parent(s.tri.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int32_t t) {
    while (parent[size_t(t)] != t) t = parent[size_t(t)] = parent[size_t(parent[size_t(t)])];
    return t;
  };
  std::map<std::pair<Corner, Corner>, int32_t> edge;
  for (size_t t = 0; t < s.tri.size(); ++t)
    for (size_t k = 0; k < 3; ++k) {
      const auto corner = [&](size_t c) { return Corner{s.tri[t][c], {s.uv[t][c].x(), s.uv[t][c].y()}}; };
      const Corner a = corner(k), b = corner((k + 1) % 3);
      const auto [at, fresh] = edge.try_emplace(std::minmax(a, b), int32_t(t));
      if (!fresh) parent[size_t(root(int32_t(t)))] = root(at->second);
    }
  std::vector<int32_t> number(s.tri.size(), -1), out(s.tri.size());
  int32_t n = 0;
  for (size_t t = 0; t < s.tri.size(); ++t) {
    int32_t& chart = number[size_t(root(int32_t(t)))];
    if (chart < 0) chart = n++;
    out[t] = chart;
  }
  return out;
}

/// Only the triangles listed, with their vertices: a chart's tree does not hold the rest of the surface.
Bvh tree_of(const ColouredSurface& s, std::span<const int32_t> triangles) {
  std::map<int32_t, int32_t> place;
  std::vector<Vec3> X;
  std::vector<Tri> tri;
  for (const int32_t t : triangles) {
    Tri& mine = tri.emplace_back();
    for (size_t k = 0; k < 3; ++k) {
      const int32_t v = s.tri[size_t(t)][k];
      const auto [at, fresh] = place.try_emplace(v, int32_t(X.size()));
      if (fresh) X.push_back(s.X_mm[size_t(v)]);
      mine[k] = at->second;
    }
  }
  return Bvh(X, tri);
}

}  // namespace

FaceTexture::FaceTexture(const ColouredSurface& s)
    : image_(s.image), tri_(s.tri), uv_(s.uv), rgb_(s.rgb), all_(s.X_mm, s.tri) {
  if (!image_) return;
  chart_of_ = charts(s);
  for (size_t t = 0; t < chart_of_.size(); ++t) {
    const size_t c = size_t(chart_of_[t]);
    if (c >= chart_.size()) chart_.emplace_back();
    chart_[c].triangle.push_back(int32_t(t));
  }
  for (Chart& c : chart_) c.bvh = tree_of(s, c.triangle);
}

std::array<Eigen::Vector2f, 3> FaceTexture::uv(const std::array<Vec3, 3>& X) const {
  const Bvh::Closest middle = all_.closest((X[0] + X[1] + X[2]) / 3);
  const Chart& chart = chart_[size_t(chart_of_[size_t(middle.triangle)])];
  std::array<Eigen::Vector2f, 3> out;
  for (size_t k = 0; k < 3; ++k) {
    const Bvh::Closest at = chart.bvh.closest(X[k]);
    const auto& corner = uv_[size_t(chart.triangle[size_t(at.triangle)])];
    out[k] = float(at.bary[0]) * corner[0] + float(at.bary[1]) * corner[1] + float(at.bary[2]) * corner[2];
  }
  return out;
}

std::array<uint8_t, 4> FaceTexture::colour(const Vec3& X) const {
  const Bvh::Closest at = all_.closest(X, kNone_mm);
  if (at.triangle < 0) return {};
  const double seen = std::clamp((kNone_mm - at.distance_mm) / (kNone_mm - kWhole_mm), 0.0, 1.0);
  std::array<uint8_t, 4> out{0, 0, 0, uint8_t(255 * seen + 0.5)};
  if (image_) return out;
  Vec3f sum = Vec3f::Zero();
  for (size_t k = 0; k < 3; ++k) sum += float(at.bary[k]) * rgb_[size_t(tri_[size_t(at.triangle)][k])];
  for (size_t k = 0; k < 3; ++k) out[k] = uint8_t(255 * std::clamp(sum[Eigen::Index(k)], 0.0f, 1.0f) + 0.5f);
  return out;
}

}  // namespace limberg
