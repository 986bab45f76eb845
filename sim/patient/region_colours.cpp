#include "sim/patient/region_colours.h"

#include <algorithm>

namespace limberg {
namespace {

constexpr double kBlur_mm = 0.6;  // from nothing to all of a colour, across a region's border
constexpr double kMost = 230;     // of 255: the tissue's own pattern shows through
constexpr double kOnSkin_mm = 1e-3;

/// Of skin that a scan gave colours to.
std::array<uint8_t, 4> scanned_colour(const Body& body, const Bvh::Closest& on) {
  if (body.rgb.empty() || on.distance_mm > kOnSkin_mm) return {};
  const size_t t = size_t(on.triangle);
  if (!body.surface.tag.empty() && body.surface.tag[t] != SurfaceTag::skin) return {};
  Vec3f colour = Vec3f::Zero();
  for (size_t k = 0; k < 3; ++k) colour += float(on.bary[k]) * body.rgb[size_t(body.surface.tri[t][k])];
  std::array<uint8_t, 4> out{};
  for (size_t c = 0; c < 3; ++c) out[c] = uint8_t(255 * colour[Eigen::Index(c)] + 0.5f);
  out[3] = 255;
  return out;
}

std::array<uint8_t, 4> colour_at(const Skin& skin, const Vec3& X, Skin::Near& near) {
  const auto& regions = skin.body().regions;
  const Skin::Place place = skin.place(X, near);
  for (size_t r = regions.size(); r-- > 0;) {
    const double share =
        std::clamp(0.5 + regions[r]->inside_mm(X, {place.depth_mm, place.down, place.thicker_mm}) / kBlur_mm, 0.0, 1.0);
    if (!(share > 0)) continue;
    const std::optional<Vec3f>& colour = regions[r]->colour();
    if (!colour) break;
    std::array<uint8_t, 4> out{};
    for (size_t c = 0; c < 3; ++c) out[c] = uint8_t(255 * (*colour)[Eigen::Index(c)] + 0.5f);
    out[3] = uint8_t(kMost * share + 0.5);
    return out;
  }
  return scanned_colour(skin.body(), near.surface);
}

}  // namespace

std::vector<std::array<uint8_t, 4>> region_colours(const Skin& skin, const SurfaceView& view,
                                                   const SurfaceTopology* before) {
  const auto& regions = skin.body().regions;
  if (skin.body().rgb.empty() &&
      std::none_of(regions.begin(), regions.end(), [](const auto& r) { return r->colour().has_value(); }))
    return {};
  std::vector<std::array<uint8_t, 4>> out(view.X_mm.size());
  Skin::Near near;
  for (size_t v = 0; v < out.size(); ++v) {
    const bool same = before && v < before->rgba.size() && before->view.X_mm[v] == view.X_mm[v];
    out[v] = same ? before->rgba[v] : colour_at(skin, view.X_mm[v], near);
  }
  return out;
}

}  // namespace limberg
