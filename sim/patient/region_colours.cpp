#include "sim/patient/region_colours.h"

#include <algorithm>

namespace limberg {
namespace {

constexpr double kBlur_mm = 0.6;  // from nothing to all of a colour, across a region's border
constexpr double kMost = 230;     // of 255: the tissue's own pattern shows through

std::array<uint8_t, 4> colour_at(const Skin& skin, const Vec3& X, Skin::Near& near) {
  const auto& regions = skin.body().regions;
  const Skin::Place place = skin.place(X, near);
  for (size_t r = regions.size(); r-- > 0;) {
    const double share =
        std::clamp(0.5 + regions[r]->inside_mm(X, {place.depth_mm, place.down, place.thicker_mm}) / kBlur_mm, 0.0, 1.0);
    if (!(share > 0)) continue;
    const std::optional<Vec3f>& colour = regions[r]->colour();
    if (!colour) return {};
    std::array<uint8_t, 4> out{};
    for (size_t c = 0; c < 3; ++c) out[c] = uint8_t(255 * (*colour)[Eigen::Index(c)] + 0.5f);
    out[3] = uint8_t(kMost * share + 0.5);
    return out;
  }
  return {};
}

}  // namespace

std::vector<std::array<uint8_t, 4>> region_colours(const Skin& skin, const SurfaceView& view,
                                                   const SurfaceTopology* before) {
  const auto& regions = skin.body().regions;
  if (std::none_of(regions.begin(), regions.end(), [](const auto& r) { return r->colour().has_value(); })) return {};
  std::vector<std::array<uint8_t, 4>> out(view.X_mm.size());
  Skin::Near near;
  for (size_t v = 0; v < out.size(); ++v) {
    const bool same = before && v < before->rgba.size() && before->view.X_mm[v] == view.X_mm[v];
    out[v] = same ? before->rgba[v] : colour_at(skin, view.X_mm[v], near);
  }
  return out;
}

}  // namespace limberg
