#include "sim/body/skin_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/body/skin.h"

namespace limberg {

std::string at_text(const Vec3& X) { return fmt::format("({:.2f}, {:.2f}, {:.2f}) mm", X.x(), X.y(), X.z()); }

double SkinView::height_mm(const ChartPoint& p) const {
  const Vec3 n = chart.normal();
  double sum = 0, weights = 0;
  for (const Vec3& X : place) {
    const double d2 = (chart.to_chart(X) - p).squaredNorm() + 1e-6, w = 1 / (d2 * d2);
    sum += w * (X - chart.origin_mm).dot(n), weights += w;
  }
  return weights > 0 ? sum / weights : 0;
}

bool SkinView::shows(const Vec3& X, const Vec3& normal) const {
  const Vec3 n = chart.normal();
  return normal.dot(n) > 0 && std::abs((X - chart.origin_mm).dot(n) - height_mm(chart.to_chart(X))) <= kViewDepth_mm;
}

std::optional<Vec3> place_on_skin(const Skin& skin, const Vec3& X, std::string& reason) {
  if (!X.allFinite()) return reason = "a place is not three numbers in mm; finite ones were expected", std::nullopt;
  const SkinHit hit = skin.nearest(X);
  const double off = (hit.X_mm - X).norm();
  if (hit.triangle >= 0 && off <= kOffSkin_mm) return hit.X_mm;
  return reason = fmt::format("place {} lies {:.1f} mm off the skin; one within {:g} mm was expected", at_text(X), off,
                              kOffSkin_mm),
         std::nullopt;
}

std::optional<SkinView> view_of(const Skin& skin, std::span<const Vec3> places, std::string& reason) {
  SkinView view;
  std::vector<Vec3> normals;
  Vec3 sum = Vec3::Zero(), middle = Vec3::Zero();
  for (const Vec3& X : places) {
    const auto on = place_on_skin(skin, X, reason);
    if (!on) return std::nullopt;
    // smoothed over the facets around it, as a blade's is
    const Vec3 normal = skin.frame(*on).normal;
    view.place.push_back(*on), normals.push_back(normal);
    sum += normal, middle += *on;
  }
  if (places.empty()) return reason = "there is no place; at least one was expected", std::nullopt;
  const Vec3 n = sum.normalized();
  for (size_t i = 0; i < normals.size(); ++i)
    if (!(normals[i].dot(n) >= kObliqueView))
      return reason = fmt::format(
                 "the skin turns too far between the places of the act: at {} by {:.0f} degrees from "
                 "their mean; shorter acts were expected",
                 at_text(view.place[i]),
                 elementary::acos(std::clamp(normals[i].dot(n), -1.0, 1.0)) * 180 / 3.141592653589793),
             std::nullopt;
  const Chart body = skin.body().chart();
  const Vec3 flat = body.e1 - body.e1.dot(n) * n, other = body.e2 - body.e2.dot(n) * n;
  view.chart.origin_mm = middle / double(places.size());
  view.chart.e1 = (flat.norm() > 0.3 ? flat : other).normalized();
  view.chart.e2 = n.cross(view.chart.e1);
  return view;
}

}  // namespace limberg
