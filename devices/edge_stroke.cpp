#include "devices/edge_stroke.h"

#include <algorithm>
#include <functional>

namespace limberg {

EdgeStroke::EdgeStroke() : point_(kSheets * kPoints) {}

size_t EdgeStroke::best() const {
  size_t b = 0;
  for (size_t i = 1; i < sheets_; ++i)
    if (sheet_[i].sum2 < sheet_[b].sum2) b = i;
  return b;
}

void EdgeStroke::begin(SurfaceIndex& index, const Snapshot& s, const Vec3& tip_mm, const SkinTouch* first_edge) {
  std::array<SkinTouch, kSheets> near;
  size_t found = index.sheets_near(s, tip_mm, kAmong_mm, near);
  if (first_edge && found > 1) {
    const auto same = [&](const SkinTouch& t) { return !SurfaceIndex::edge_between(s, *first_edge, t); };
    const auto others = std::stable_partition(near.begin(), near.begin() + long(found), std::not_fn(same));
    if (others != near.begin()) found = size_t(others - near.begin());
  }
  sheets_ = found;
  for (size_t i = 0; i < sheets_; ++i) sheet_[i] = {near[i], 0};
  points_ = 0;
  thinned_ = 1;
}

void EdgeStroke::follow(const SurfaceIndex& index, const Snapshot& s, const Vec3& tip_mm) {
  for (size_t i = 0; i < sheets_; ++i) sheet_[i].touch = index.closest(s, tip_mm, sheet_[i].touch.triangle);
}

void EdgeStroke::note(const Vec3& tip_mm, double step_mm) {
  if (points_ > 0 && (tip_mm - last_tip_).norm() < step_mm * thinned_) return;
  if (points_ == kPoints) {  // every other point goes
    for (size_t i = 0; i < sheets_; ++i)
      for (size_t k = 0; 2 * k < kPoints; ++k) point_[i * kPoints + k] = point_[i * kPoints + 2 * k];
    points_ = kPoints / 2;
    thinned_ *= 2;
  }
  for (size_t i = 0; i < sheets_; ++i) {
    point_[i * kPoints + points_] = {sheet_[i].touch.chart, sheet_[i].touch.x_mm, sheet_[i].touch.X_mm,
                                     sheet_[i].touch.N};
    sheet_[i].sum2 += sheet_[i].touch.distance_mm * sheet_[i].touch.distance_mm;
  }
  ++points_;
  last_tip_ = tip_mm;
}

void EdgeStroke::found_again(const SurfaceIndex& index, const Snapshot& s) {
  if (sheets_ == 0) return;
  const size_t b = best();
  if (b != 0) std::copy_n(point_.begin() + long(b * kPoints), points_, point_.begin());
  sheet_[0] = sheet_[b];
  sheet_[0].touch = index.closest(s, sheet_[b].touch.x_mm, -1);
  sheets_ = sheet_[0].touch.triangle >= 0 ? 1 : 0;
}

}  // namespace limberg
