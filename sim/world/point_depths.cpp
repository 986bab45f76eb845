#include "sim/world/point_depths.h"

#include <cmath>

namespace limberg {

void PointDepths::follow(const SurfaceView& view, const ViewChange& change, const Skin& skin, SharedArray<float>& depth_mm) {
  const auto of = [&](int32_t v) -> float& {
    const size_t point = size_t(view.point[size_t(v)]);
    if (point >= known_.size()) known_.resize(point + 1, std::nanf(""));
    return known_[point];
  };
  const auto lies_on_skin = [&](size_t t) {
    if (view.kind[t] != FaceKind::skin) return;
    for (int32_t v : view.tri[t]) of(v) = 0;
  };
  Bvh::Closest near;
  const auto set = [&](int32_t v) {
    float& depth = of(v);
    if (std::isnan(depth)) depth = float(skin.depth_mm(view.X_mm[size_t(v)], near));
    depth_mm.set(size_t(v), depth);
  };
  depth_mm.resize(view.X_mm.size());
  if (change.whole) {
    for (size_t t = 0; t < view.tri.size(); ++t) lies_on_skin(t);
    for (size_t v = 0; v < view.X_mm.size(); ++v) set(int32_t(v));
    return;
  }
  for (int32_t t : change.triangles) lies_on_skin(size_t(t));
  for (int32_t v : change.vertices) set(v);
}

}  // namespace limberg
