#include "devices/edge_stroke.h"

#include <algorithm>

namespace limberg {

EdgeStroke::EdgeStroke() : point_(kSheets * kPoints) {}

size_t EdgeStroke::best() const {
  size_t b = 0;
  for (size_t i = 1; i < sheets_; ++i)
    if (sheet_[i].sum2 < sheet_[b].sum2) b = i;
  return b;
}

void EdgeStroke::begin(SurfaceIndex& index, const Snapshot& s, const Vec3& tip_mm) {
  std::array<SkinTouch, kSheets> near;
  take(std::span(near).first(index.sheets_near(s, tip_mm, kAmong_mm, near)));
}

void EdgeStroke::begin_as_meant(SurfaceIndex& index, const Snapshot& s, const Vec3& tip_mm,
                                const SkinTouch* first_edge) {
  constexpr double kSamePlace_mm = 0.1;
  std::array<SkinTouch, kSheets + 1> near;
  near[0] = index.closest_of_all(s, tip_mm);
  size_t found = near[0].triangle >= 0;
  std::array<SkinTouch, kSheets> sheets;
  for (const SkinTouch& t : std::span(sheets).first(index.sheets_near(s, tip_mm, kAmong_mm, sheets)))
    if (found == 0 || (t.X_mm - near[0].X_mm).norm() > kSamePlace_mm) near[found++] = t;
  std::array<SkinTouch, kSheets + 1> others;
  size_t other = 0;
  for (size_t i = 0; i < found && first_edge; ++i)
    if (SurfaceIndex::edge_between(s, *first_edge, near[i])) others[other++] = near[i];
  if (other > 0) near = others, found = other;
  take(std::span(near).first(std::min(found, kSheets)));
}

void EdgeStroke::take(std::span<const SkinTouch> near) {
  sheets_ = near.size();
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
