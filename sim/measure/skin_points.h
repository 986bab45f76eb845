#pragma once
// Named places of the skin: where a chart point is on what remains of it, at rest and now.
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "sim/body/skin.h"
#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

class SkinPoints {
 public:
  /// Keeps references to both. O(triangles)
  SkinPoints(const SurfaceView& view, const Skin& skin);

  struct Place {
    int32_t triangle = -1;
    std::array<double, 3> bary{};
  };
  /// Nothing off the skin, and where the skin has been removed. On a cut one of the banks.
  std::optional<Place> find(const ChartPoint& p) const;
  Vec3 rest_mm(const Place& p) const;
  Vec3 now_mm(const Place& p, std::span<const Vec3f> x_mm) const;

 private:
  const SurfaceView& view_;
  const Skin& skin_;
  std::map<std::pair<int, int>, std::vector<int32_t>> bucket_;  // of the chart
};

/// What has become of a landmark.
struct LandmarkFigure {
  double displacement_mm = 0;                     // from its place at rest
  double along_mm = 0, across_mm = 0, up_mm = 0;  // in the skin's tension axes there, up: outward
};
std::optional<LandmarkFigure> landmark(const SkinPoints& points, std::span<const Vec3f> x_mm, const Skin& skin,
                                       const ChartPoint& p);

}  // namespace limberg
