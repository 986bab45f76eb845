#pragma once
// The piece of skin that the tip of a hook or the bite of a stitch holds.
//
// A force on a point has no limit as cells shrink, nor has one on a line, as the edge of a wound is: the tissue under
// it gives way without end. A tip has a size, and a needle goes in behind the edge. Their places are found by walking
// along the skin at rest, straight ahead from triangle to triangle, and a walk that comes to a wound's edge holds
// nothing: the other bank is never reached, however near it lies.
#include <optional>
#include <vector>

#include "sim/patient/rest_index.h"

namespace limberg {

/// Places of a round tip that bears evenly: its middle and rings of 6, 12 and 24 around it, all with an equal part of
/// the disc, where their mean distance squared is the disc's, r^2 / 2. The middle comes first; those that the skin does
/// not reach are left out. O(triangles)
std::vector<SurfacePoint> skin_patch(const SurfaceView& view, const SurfacePoint& middle, double radius_mm);

struct PatchPlace {
  SurfacePoint at;
  double share = 0;
};

/// What a stitch through `middle` holds: skin (of a middle in a wound's wall, wall) as far as `radius_mm` around it, at
/// a wound's edge half a disc. Shares are the area's times a linear function of the place, with sum 1 and no first
/// moment about `middle`: where tissue moves as an affine map does, the mean of the places is the middle, and what
/// pulls at it has the force and the moment of a pull at the middle. So edges are drawn to meet by what lies behind
/// them, and their parts farthest from the edge have shares below 0. A middle without area around it is held alone.
/// O(triangles)
std::vector<PatchPlace> bite_patch(const SurfaceView& view, const SurfacePoint& middle, double radius_mm);

/// The skin as triangles with neighbours, as far as a ball reaches; with another kind the faces of that.
class SkinWalk {
 public:
  SkinWalk(const SurfaceView& view, const Vec3& middle_mm, double reach_mm, FaceKind kind = FaceKind::skin);
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
