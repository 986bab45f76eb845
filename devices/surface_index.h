#pragma once
// Finding skin: the nearest skin to a point in the deformed world, and the skin under a chart point at rest.
//
// Built once per topology version. The closest point is found by walking: from the triangle touched last, over
// triangles that share a vertex, for as long as that brings the surface nearer. A walk cannot leave its bank of a
// wound, so now and then (and at first) it starts from the nearest of all skin vertices, found by one pass over them.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/patient/snapshot.h"

namespace limberg {

/// A point of the deformed skin.
struct SkinTouch {
  int32_t triangle = -1;  // of the view; -1: none
  std::array<double, 3> bary{1, 0, 0};
  Vec3 x_mm = Vec3::Zero();     // deformed
  Vec3 normal = Vec3::UnitZ();  // deformed, unit, outward
  Vec3 X_mm = Vec3::Zero();     // at rest
  ChartPoint chart{0, 0};
  double distance_mm = 1e30;  // from the query point
};

class SurfaceIndex {
 public:
  /// Reads the topology; keeps no reference to it. `ground`: of what it is an index; "skin" below stands for that.
  void build(const SurfaceTopology& topology, Ground ground = Ground::skin);
  bool built_for(const Snapshot& s) const { return built_ && s.topology && version_ == s.topology->version; }

  /// Closest skin point to p. `hint`: a triangle touched before, or -1 for a search over all the skin.
  SkinTouch closest(const Snapshot& s, const Vec3& p_mm, int32_t hint) const;

  /// The sheets of skin near p: the closest point, then the closest of the skin that does not hang together with it
  /// within kSheetRadius_mm, and so on while no more than `among_mm` further away. How many of `out` were filled.
  size_t sheets_near(const Snapshot& s, const Vec3& p_mm, double among_mm, std::span<SkinTouch> out);

  /// The closest skin point to p that does not hang together with `other` nearby (the other bank of a wound, the bed
  /// under a flap), if it is within `reach_mm`; else triangle -1.
  SkinTouch closest_apart(const Snapshot& s, const Vec3& p_mm, const SkinTouch& other, double reach_mm);

  /// Corners of the skin triangles around a touched place, those first that are fewest triangles away, none further
  /// than reach_mm; as many as fit. How many. Allocates nothing.
  int facets_around(const Snapshot& s, const SkinTouch& place, double reach_mm,
                    std::span<std::array<Vec3, 3>> out) const;

  static constexpr double kSheetRadius_mm = 4;  // at rest

  /// The skin point above chart point c at rest, in its deformed place; outermost where several skins lie over one
  /// another. Where c is off the remaining skin (in a hole, on a rim), the nearest skin in the chart within slack_mm.
  /// triangle -1: there is none. distance_mm is the distance in the chart.
  SkinTouch at_chart(const Snapshot& s, const ChartPoint& c, double slack_mm = 0) const;

  size_t skin_triangles() const { return skin_tri_.size(); }

 private:
  struct Place {
    int32_t triangle = -1;
    std::array<double, 3> bary{1, 0, 0};
    double distance2 = 1e60;
  };
  SkinTouch touch(const Snapshot& s, const Place& place) const;
  Place walk(const Snapshot& s, const Vec3& p_mm, int32_t triangle) const;
  int32_t nearest_vertex(const Snapshot& s, const Vec3& p_mm, bool unmarked_only) const;
  void mark_sheet(const Snapshot& s, const SkinTouch& middle);
  int cell_x(double x) const;
  int cell_y(double y) const;

  bool built_ = false;
  uint64_t version_ = 0;
  std::vector<int32_t> skin_tri_;           // triangles of the view that are skin
  std::vector<int32_t> skin_vertex_;        // their vertices, each once
  std::vector<int32_t> star_start_, star_;  // per view vertex: its skin triangles
  std::vector<uint8_t> mark_;               // per view vertex: on a sheet that was found already
  std::vector<int32_t> marked_;
  // Uniform grid over the chart: skin triangles whose chart box meets a cell.
  double cell_mm_ = 2;
  Vec2 grid_min_{0, 0};
  int nx_ = 0, ny_ = 0;
  std::vector<int32_t> cell_start_, cell_tri_;
};

}  // namespace limberg
