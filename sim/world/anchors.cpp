#include "sim/world/anchors.h"

namespace limberg {
namespace {

// How far the hint moves towards the triangle's centroid: small against any triangle, large against rounding.
constexpr double kInside = 0.05;
// A carried hint is found again within this distance: it lies inside the old triangle, so inside one of its parts.
constexpr double kCarrySlack_mm = 1e-3;

}  // namespace

Anchor make_anchor(const SurfaceView& view, const RestIndex& index, const SurfacePoint& point) {
  Anchor a;
  a.at = point;
  a.X_mm = index.rest_mm(point);
  const SurfacePoint centre{point.triangle, Vec3::Constant(1.0 / 3)};
  a.hint_mm = (1 - kInside) * a.X_mm + kInside * index.rest_mm(centre);
  a.origin = view.origin[size_t(point.triangle)];
  return a;
}

std::optional<Anchor> carry_anchor(const Anchor& anchor, const SurfaceView& view, const RestIndex& index) {
  const auto at = index.locate(anchor.hint_mm, anchor.origin, kCarrySlack_mm);
  if (!at || view.kind[size_t(at->triangle)] == FaceKind::wall) return std::nullopt;
  Anchor next = anchor;
  // The hint chose the bank; the weights are those of the held point itself on that triangle.
  next.at.triangle = at->triangle;
  next.at.bary = index.weights(at->triangle, anchor.X_mm);
  return next;
}

double path_length_mm(const std::vector<Vec2>& path) {
  double length = 0;
  for (size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  return length;
}

std::vector<Vec2> resample(const std::vector<Vec2>& path, int n) {
  const double total = path_length_mm(path);
  std::vector<Vec2> out;
  out.reserve(size_t(n));
  size_t i = 1;
  double before = 0;  // arc length at path[i - 1]
  for (int k = 0; k < n; ++k) {
    const double s = total * k / (n - 1);
    while (i + 1 < path.size() && before + (path[i] - path[i - 1]).norm() < s) before += (path[i] - path[i - 1]).norm(), ++i;
    const double length = (path[i] - path[i - 1]).norm();
    const double t = length > 0 ? std::min(1.0, (s - before) / length) : 0;
    out.push_back(path[i - 1] + t * (path[i] - path[i - 1]));
  }
  return out;
}

}  // namespace limberg
