#include "sim/contact/neighbours.h"

#include <algorithm>

namespace limberg {
namespace {

constexpr double kNear_mm = 5;       // so far at rest a surface has neighbours
constexpr double kOpposed = -0.5;    // cosine between the rest normals of two sides that face each other
constexpr double kBehind_mm = 0.02;  // before or behind a rest plane; the banks of one cut are at 0

}  // namespace

Neighbours::Neighbours(std::shared_ptr<const ContactSurface> surface) : surface_(std::move(surface)), reached_(surface_->place.size()) {
  for (const Tri& t : surface_->tri)
    middle_.push_back((surface_->X_mm[size_t(t[0])] + surface_->X_mm[size_t(t[1])] + surface_->X_mm[size_t(t[2])]) / 3);
}

const std::vector<int32_t>& Neighbours::reached(const Place& place) {
  std::vector<int32_t>& out = reached_[place.index];
  if (!out.empty()) return out;
  std::vector<int32_t> open{place.triangle};
  out = open;
  while (!open.empty()) {
    const int32_t t = open.back();
    open.pop_back();
    for (int32_t v : surface_->tri[size_t(t)])
      for (int32_t next : surface_->triangles_around(v)) {
        if ((middle_[size_t(next)] - place.X_mm).squaredNorm() > kNear_mm * kNear_mm) continue;
        const auto at = std::lower_bound(out.begin(), out.end(), next);
        if (at != out.end() && *at == next) continue;
        out.insert(at, next);
        open.push_back(next);
      }
  }
  return out;
}

bool Neighbours::other(const Place& place, int32_t t, const Vec3& X_mm, const Vec3& N) {
  const Vec3 apart = X_mm - place.X_mm;
  if (apart.squaredNorm() >= kNear_mm * kNear_mm) return true;
  if (place.N.dot(N) < kOpposed) {
    const double a = apart.dot(place.N), b = -apart.dot(N);  // positive: in front
    if (std::max(a, b) > kBehind_mm || std::min(a, b) > -kBehind_mm) return true;
    if (std::max(a, b) < -kBehind_mm) return false;  // through the tissue between them
  }
  const std::vector<int32_t>& own = reached(place);
  return !std::binary_search(own.begin(), own.end(), t);
}

}  // namespace limberg
