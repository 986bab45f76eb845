#pragma once
// The piece of skin that the tip of a hook holds.
//
// A force on a point has no limit as cells shrink: the tissue under it gives way without end. A tip has a size. Its
// places are found by walking along the skin at rest, straight ahead from triangle to triangle, and a walk that comes
// to a wound's edge holds nothing: the other bank is never reached, however near it lies.
#include <optional>
#include <vector>

#include "sim/patient/rest_index.h"

namespace limberg {

/// Places of a round tip that bears evenly: its middle and six around it, at .76 of the radius, where their mean
/// distance squared is a disc's, r^2 / 2. The middle comes first; those that the skin does not reach are left out.
/// O(triangles)
std::vector<SurfacePoint> skin_patch(const SurfaceView& view, const SurfacePoint& middle, double radius_mm);

/// The skin as triangles with neighbours, as far as a ball reaches.
class SkinWalk {
 public:
  SkinWalk(const SurfaceView& view, const Vec3& middle_mm, double reach_mm);
  /// So far straight ahead from a place, in a direction of its triangle's plane; nothing when the skin ends before.
  std::optional<SurfacePoint> ahead(const SurfacePoint& from, Vec3 direction, double way_mm) const;

 private:
  struct Edge {
    int32_t from, to, triangle;
    auto operator<=>(const Edge&) const = default;
  };
  int32_t beyond(int32_t triangle, int edge) const;  // -1: none
  const SurfaceView& view_;
  std::vector<Edge> edge_;  // ascending
};

}  // namespace limberg
