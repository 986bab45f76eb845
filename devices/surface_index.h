#pragma once
// Finding skin: the nearest skin to a point in the deformed world, and the sheets of skin that lie near one another.
// What lies under a chart point is found by skin_chart.h.
//
// The closest point is found by walking: from the triangle touched last, over triangles that share a vertex, for as
// long as that brings the surface nearer. A walk cannot leave its bank of a wound, so now and then (and at first) it
// starts from the nearest of all skin vertices, found by one pass over them. Which triangles share a vertex is read off
// the topology (ground_index.h). Nothing is allocated after construction, whatever the topology does.
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
  Vec3 N = Vec3::UnitZ();       // at rest, unit, outward
  ChartPoint chart{0, 0};
  double distance_mm = 1e30;  // from the query point
};

/// A set of vertices in the order in which they were put in, of bounded size and in memory of its own.
class VertexSet {
 public:
  static constexpr size_t kMost = 1 << 13;  // a sheet of 4 mm radius at edges of a tenth of a millimetre
  VertexSet() : slot_(2 * kMost, -1) { order_.reserve(kMost); }
  bool contains(int32_t v) const { return slot_[place(v)] == v; }
  /// False: the set is full.
  bool insert(int32_t v);
  void clear();
  size_t size() const { return order_.size(); }
  int32_t operator[](size_t i) const { return order_[i]; }

 private:
  size_t place(int32_t v) const;
  std::vector<int32_t> slot_, order_;
};

/// A point of the view's triangle with such barycentric coordinates, as it lies now.
SkinTouch touch_at(const Snapshot& s, int32_t triangle, const std::array<double, 3>& bary, double distance_mm);

class SurfaceIndex {
 public:
  /// `ground`: what is searched; "skin" below stands for that.
  explicit SurfaceIndex(Ground ground = Ground::skin) : ground_(ground) {}
  Ground ground() const { return ground_; }
  /// Whether the topology is another than at the last look: triangles known from before are not of this one.
  bool another(const Snapshot& s);

  /// Closest skin point to p. `hint`: a triangle touched before, or -1 for a search over all the skin.
  SkinTouch closest(const Snapshot& s, const Vec3& p_mm, int32_t hint) const;

  /// The same, exactly: the walk above ends on the sheet whose vertex is nearest, and where triangles are larger than
  /// the gap between two sheets that may be the farther one. O(triangles), for the moment of a press.
  SkinTouch closest_of_all(const Snapshot& s, const Vec3& p_mm) const;

  /// The sheets of skin near p: the closest point, then the closest of the skin that does not hang together with it
  /// within kSheetRadius_mm, and so on while no more than `among_mm` further away. How many of `out` were filled.
  size_t sheets_near(const Snapshot& s, const Vec3& p_mm, double among_mm, std::span<SkinTouch> out);

  /// The closest skin point to p that does not hang together with `other` nearby (the other bank of a wound, the bed
  /// under a flap), if it is within `reach_mm`; else triangle -1. `exactly`: O(triangles), as closest_of_all().
  SkinTouch closest_apart(const Snapshot& s, const Vec3& p_mm, const SkinTouch& other, double reach_mm,
                          bool exactly = false);

  /// Whether an edge of a wound crosses the straight way from one place to another at rest, seen from above them: then
  /// they are on two banks, also where the skin hangs together round the end of a cut. O(triangles)
  static bool edge_between(const Snapshot& s, const SkinTouch& from, const SkinTouch& to);

  /// Corners of the skin triangles around a touched place, those first that are fewest triangles away, none further
  /// than reach_mm; as many as fit. How many.
  int facets_around(const Snapshot& s, const SkinTouch& place, double reach_mm,
                    std::span<std::array<Vec3, 3>> out) const;

  static constexpr double kSheetRadius_mm = 4;  // at rest

 private:
  struct Place {
    int32_t triangle = -1;
    std::array<double, 3> bary{1, 0, 0};
    double distance2 = 1e60;
  };
  /// The nearest place to p on the surface, if it is nearer than `best`, else `best`. Sheets that are marked are left
  /// out, and with them the skin around that leads to them.
  Place nearer(const Snapshot& s, const Vec3& p_mm, Place best) const;
  const GroundIndex& of(const Snapshot& s) const { return s.topology->index(ground_); }
  SkinTouch touch(const Snapshot& s, const Place& place) const;
  Place walk(const Snapshot& s, const Vec3& p_mm, int32_t triangle) const;
  Place walk_from_vertex(const Snapshot& s, const Vec3& p_mm, int32_t vertex) const;
  int32_t nearest_vertex(const Snapshot& s, const Vec3& p_mm, bool unmarked_only) const;
  void mark_sheet(const Snapshot& s, const SkinTouch& middle);
  bool marked(const Snapshot& s, int32_t triangle) const;

  Ground ground_;
  uint64_t version_ = 0;
  bool looked_ = false;
  VertexSet mark_;  // vertices of sheets that were found already
};

}  // namespace limberg
