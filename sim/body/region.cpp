#include "sim/body/region.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/quoted.h"
#include "sim/body/body.h"
#include "sim/geometry/polyline.h"

namespace limberg {
namespace {

size_t nearest_segment(const std::vector<Vec3>& path, const Vec3& X, double& distance) {
  size_t best = 0;
  distance = (X - path[0]).norm();
  for (size_t i = 0; i + 1 < path.size(); ++i)
    if (const double d = distance_to_segment(X, path[i], path[i + 1]); d < distance) distance = d, best = i;
  return best;
}

double inside_outline(const std::vector<ChartPoint>& outline, const ChartPoint& p) {
  double least = INFINITY;
  for (size_t i = 0; i < outline.size(); ++i)
    least = std::min(least, distance_to_segment(p, outline[i], outline[(i + 1) % outline.size()]));
  return inside_polygon(outline, p) ? least : -least;
}

}  // namespace

Region::Region(RegionSpec spec, const Body& body) : spec_(std::move(spec)), chart_(body.chart()) {
  if (!spec_.volume.empty()) {
    ColliderSpec file;
    file.path = spec_.volume, file.scale_to_mm = spec_.scale_to_mm, file.what = "region";
    mesh_ = load_collider(file)->mesh;
  } else if (!spec_.paint.empty()) {
    const auto at = std::find(body.paints.begin(), body.paints.end(), spec_.paint);
    const int32_t paint = at == body.paints.end() ? -2 : int32_t(at - body.paints.begin());
    mesh_.X_mm = body.surface.X_mm;
    for (size_t t = 0; t < body.paint_of.size(); ++t)
      if (body.paint_of[t] == paint) mesh_.tri.push_back(body.surface.tri[t]);
    if (mesh_.tri.empty())
      throw InputError("", 0,
                       "region " + limberg::quoted(spec_.name) + " is painted " + limberg::quoted(spec_.paint) +
                           ", and no face of the body's surface is of that material; expected usemtl " +
                           limberg::quoted(spec_.paint) + " in its file");
  }
  if (!(spec_.from_mm > 0)) spec_.from_mm = -INFINITY;  // up to the skin, which ends it anyway
  if (!mesh_.tri.empty()) patch_ = SidedPatch(mesh_);
}

std::optional<double> Region::activation() const {
  for (const LawSpec::Constant& c : spec_.material.law.constants)
    if (c.key == kActivation && c.value.size() == 1) return c.value[0];
  return std::nullopt;
}

double Region::inside_beside_mm(const Vec3& X, const Below& below) const {
  constexpr double far_mm = 1e3;
  Bvh::Closest near;
  if (!spec_.volume.empty()) return patch_.depth_mm(X, near);
  if (!spec_.path_mm.empty()) {
    double distance = 0;
    nearest_segment(spec_.path_mm, X, distance);
    return spec_.radius_mm - distance;
  }
  if (!spec_.outline_mm.empty()) {
    if (below.down.dot(chart_.normal()) > 0)
      return -far_mm;  // on a closed body the chart's lines meet the far side too
    return inside_outline(spec_.outline_mm, chart_.to_chart(X));
  }
  const double beside = std::abs(patch_.depth_mm(X, near)) - std::abs(below.depth_mm);
  return beside > 1e-6 ? -beside : far_mm;
}

std::optional<size_t> region_at(const Body& body, const Vec3& X, const Region::Below& below) {
  for (size_t r = body.regions.size(); r-- > 0;)
    if (body.regions[r]->inside_mm(X, below) > 0) return r;
  return std::nullopt;
}

std::optional<Vec3> Region::direction(const Vec3& X) const {
  if (spec_.direction) return spec_.direction->normalized();
  if (spec_.path_mm.size() < 2) return std::nullopt;
  double distance = 0;
  const size_t at = nearest_segment(spec_.path_mm, X, distance);
  return (spec_.path_mm[at + 1] - spec_.path_mm[at]).normalized();
}

}  // namespace limberg
