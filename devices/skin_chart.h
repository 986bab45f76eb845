#pragma once
// The skin under a point of the chart: a uniform grid over the chart, made once per version of the topology. For
// whoever plans on the chart (the emulated surgeon), not for the device thread: making it allocates.
#include <cstdint>
#include <span>
#include <vector>

#include "devices/surface_index.h"

namespace limberg {

class SkinChart {
 public:
  /// Reads the topology; keeps no reference to it.
  void build(const SurfaceTopology& topology);
  bool built_for(const Snapshot& s) const { return built_ && s.topology && version_ == s.topology->version; }

  /// The skin point above chart point c at rest, in its deformed place; outermost where several skins lie over one
  /// another. Where c is off the remaining skin (in a hole, on a rim), the nearest skin in the chart within slack_mm.
  /// triangle -1: there is none. distance_mm is the distance in the chart.
  SkinTouch at(const Snapshot& s, const ChartPoint& c, double slack_mm = 0) const;

  /// The skin that lies nearest to X at rest, in its deformed place; triangle -1 where there is none within reach_mm.
  /// O(triangles of skin)
  static SkinTouch at_rest(const Snapshot& s, const Vec3& X_mm, double reach_mm);
  /// The skin nearest to X at rest among these triangles; where `out` is given, among those that look along it at rest.
  static SkinTouch at_rest(const Snapshot& s, const Vec3& X_mm, double reach_mm, std::span<const int32_t> triangles,
                           const Vec3* out = nullptr);
  /// Where the line through X along `out` meets skin that looks that way at rest, nearest to X, in its deformed place;
  /// triangle -1 where it meets none within reach_mm. O(triangles of skin)
  static SkinTouch on_line_at_rest(const Snapshot& s, const Vec3& X_mm, const Vec3& out, double reach_mm);

 private:
  int cell_x(double x) const;
  int cell_y(double y) const;

  bool built_ = false;
  uint64_t version_ = 0;
  // Skin triangles whose chart box meets a cell.
  double cell_mm_ = 2;
  Vec2 grid_min_{0, 0};
  int nx_ = 0, ny_ = 0;
  std::vector<int32_t> cell_start_, cell_tri_;
};

}  // namespace limberg
