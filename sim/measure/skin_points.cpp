#include "sim/measure/skin_points.h"

#include <cmath>

#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr double kBucket_mm = 3, kFound_mm = 0.05;

std::pair<int, int> bucket_of(const Vec2& p) {
  return {int(std::floor(p.x() / kBucket_mm)), int(std::floor(p.y() / kBucket_mm))};
}

}  // namespace

SkinPoints::SkinPoints(const SurfaceView& view, const Skin& skin) : view_(view), skin_(skin) {
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    Vec2 lo = Vec2::Constant(1e300), hi = -lo;
    for (const int32_t v : view.tri[t]) {
      const Vec2 c = skin.body().to_chart(view.X_mm[size_t(v)]);
      lo = lo.cwiseMin(c), hi = hi.cwiseMax(c);
    }
    const auto a = bucket_of(lo), b = bucket_of(hi);
    for (int i = a.first; i <= b.first; ++i)
      for (int k = a.second; k <= b.second; ++k) bucket_[{i, k}].push_back(int32_t(t));
  }
}

std::optional<SkinPoints::Place> SkinPoints::find(const ChartPoint& p) const {
  const auto hit = p.allFinite() ? skin_.at(p) : std::nullopt;
  const auto at = hit ? bucket_.find(bucket_of(p)) : bucket_.end();
  if (at == bucket_.end()) return std::nullopt;
  std::optional<Place> best;
  double nearest = kFound_mm;
  for (const int32_t t : at->second) {
    const Tri& c = view_.tri[size_t(t)];
    const TrianglePoint q =
        closest_on_triangle(hit->X_mm, view_.X_mm[size_t(c[0])], view_.X_mm[size_t(c[1])], view_.X_mm[size_t(c[2])]);
    const double d = (q.point - hit->X_mm).norm();
    if (d < nearest) nearest = d, best = Place{t, q.bary};
  }
  return best;
}

Vec3 SkinPoints::rest_mm(const Place& p) const {
  Vec3 X = Vec3::Zero();
  for (size_t k = 0; k < 3; ++k) X += p.bary[k] * view_.X_mm[size_t(view_.tri[size_t(p.triangle)][k])];
  return X;
}

Vec3 SkinPoints::now_mm(const Place& p, std::span<const Vec3f> x_mm) const {
  Vec3 x = Vec3::Zero();
  for (size_t k = 0; k < 3; ++k) x += p.bary[k] * x_mm[size_t(view_.tri[size_t(p.triangle)][k])].cast<double>();
  return x;
}

std::optional<LandmarkFigure> landmark(const SkinPoints& points, std::span<const Vec3f> x_mm, const Skin& skin,
                                       const ChartPoint& p) {
  const auto at = points.find(p);
  if (!at) return std::nullopt;
  const Vec3 X = points.rest_mm(*at), d = points.now_mm(*at, x_mm) - X;
  const Skin::Frame f = skin.frame(X);
  return LandmarkFigure{d.norm(), d.dot(f.along), d.dot(f.across), d.dot(f.normal)};
}

}  // namespace limberg
