#include "sim/measure/raw_tissue.h"

#include <algorithm>
#include <optional>

#include "sim/geometry/bvh.h"
#include "sim/geometry/triangle.h"
#include "sim/measure/attached.h"
#include "sim/measure/corners.h"

namespace limberg {
namespace {

constexpr double kAboveSkin_mm = 0.5;  // less is a step-off, which the gape measures
constexpr double kLooksOut = 0.5;      // cos 60 degrees
constexpr double kOff_mm = 1e-3;       // a ray leaves its own face
constexpr double kFar_mm = 50;         // farther away nothing hides it: another side of the patient

}  // namespace

RawTissue raw_tissue(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin) {
  RawTissue raw;
  const std::vector<uint8_t> is_attached = attached(view);
  std::optional<Bvh> all;  // as it lies now; most wounds need none
  const auto hidden = [&](const Vec3& from, const Vec3& up) {
    if (!all) all = Bvh(view.X_mm.flat(), view.tri.flat()), all->refit(x_mm);
    return !all->line(from, up, kOff_mm, kFar_mm).empty();
  };
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::wall || !is_attached[size_t(view.tri[t][0])]) continue;
    const auto x = corners_now(view, x_mm, t);
    const Vec3 middle = (x[0] + x[1] + x[2]) / 3, n = area_vector2(x[0], x[1], x[2]);
    const double height_mm = -skin.depth_mm(middle);
    if (!(height_mm > kAboveSkin_mm)) continue;
    const Vec3 up = skin.nearest(middle).normal;
    if (!(n.dot(up) > kLooksOut * n.norm()) || hidden(middle, up)) continue;
    const double area = 0.5 * n.norm();
    raw.area_mm2 += area;
    raw.height_mm = std::max(raw.height_mm, height_mm);
    for (const int32_t v : view.tri[t]) raw.at_mm += area / 3 * view.X_mm[size_t(v)];
  }
  if (raw.area_mm2 > 0) raw.at_mm /= raw.area_mm2;
  return raw;
}

}  // namespace limberg
