#include "sim/patient/point_depths.h"

#include <algorithm>
#include <utility>

namespace limberg {

struct PointDepths::Asked {
  SharedArray<Vec3> X_mm;
  SharedArray<int32_t> point;
  SharedArray<uint8_t> on_skin;
  std::shared_ptr<const Skin> skin;
  std::shared_ptr<Last> last;
  bool in_layers = false;
};

namespace {

double depth_of(const Skin& skin, const Vec3& X, bool in_layers) {
  Bvh::Closest near;
  const double depth = skin.depth_mm(X, near);
  if (!in_layers) return depth;
  const double counted = skin.in_layers_mm(depth, near), usual = skin.body().layers[0].thickness_mm;
  return depth > 0 && counted < usual ? depth * usual / (usual + depth - counted) : counted;
}

}  // namespace

Lazy<SharedArray<float>> PointDepths::follow(const SurfaceView& view, const ViewChange& change,
                                             std::shared_ptr<const Skin> skin, SharedArray<uint8_t>& on_skin) {
  const auto lies_on_skin = [&](size_t t) {
    if (view.kind[t] != FaceKind::skin) return;
    for (int32_t v : view.tri[t]) {
      const size_t point = size_t(view.point[size_t(v)]);
      if (point >= on_skin.size()) on_skin.resize(point + 1, 0);
      on_skin.set(point, 1);
    }
  };
  if (change.whole)
    for (size_t t = 0; t < view.tri.size(); ++t) lies_on_skin(t);
  else
    for (int32_t t : change.triangles) lies_on_skin(size_t(t));
  return Lazy<SharedArray<float>>(
      [asked = Asked{view.X_mm, view.point, on_skin, std::move(skin), last_, in_layers_}] { return find(asked); });
}

SharedArray<float> PointDepths::find(const Asked& asked) {
  Last& last = *asked.last;
  const std::lock_guard lock(last.mutex);
  const SharedArray<Vec3>&X = asked.X_mm, &X_then = last.X_mm;
  const SharedArray<int32_t>& point_then = last.point;
  SharedArray<float> depth = last.depth_mm;
  depth.resize(X.size());
  for (size_t c = 0; c < X.chunks(); ++c) {
    if (X.shares(X_then, c)) continue;
    const size_t first = c * SharedArray<Vec3>::kChunk, end = first + X.run_length(c);
    for (size_t v = first; v < end; ++v) {
      const int32_t point = asked.point[v];
      if (v < X_then.size() && X_then[v] == X[v] && point_then[v] == point) continue;
      const bool on_skin = size_t(point) < asked.on_skin.size() && asked.on_skin[size_t(point)];
      depth.set(v, on_skin ? 0 : float(depth_of(*asked.skin, X[v], asked.in_layers)));
    }
  }
  last.X_mm = X;
  last.point = asked.point;
  last.depth_mm = depth;
  return depth;
}

}  // namespace limberg
