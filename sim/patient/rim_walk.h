#pragma once
// The edge of a wound as a line that can be walked: rim edges in their order around the skin.
//
// Walked forward the skin lies on the left. The rim of a slit is one loop along both its banks, so a row of stitches
// between two key stitches walks forward on one bank and backward on the other. Everything is at rest.
#include <optional>
#include <utility>
#include <vector>

#include "sim/patient/rest_index.h"

namespace limberg {

class RimWalk {
 public:
  /// O(triangles)
  explicit RimWalk(const SurfaceView& view);

  /// A place on the rim: its edge, and how far along it from 0 to 1.
  struct Spot {
    int32_t edge = -1;
    double at = 0;
  };
  /// The rim edge that the point lies on; nothing when it is
  /// farther than a micrometre from every rim edge of its triangle.
  std::optional<Spot> spot(const SurfacePoint& p) const;

  /// The way from one spot to another: its length, and the point
  /// at any share of it. Nothing when they lie on different rims.
  struct Way {
    bool forward = true;
    double length_mm = 0;
    std::vector<std::pair<Spot, double>> corner;  // spots with the length walked to them; first and last are the ends
  };
  std::optional<Way> way(const Spot& from, const Spot& to, bool forward) const;
  SurfacePoint point(const Way& way, double share) const;
  /// The place so far along the rim from a spot, forward or (below 0) backward; nothing when the rim ends before.
  std::optional<SurfacePoint> along(const Spot& from, double by_mm) const;

  SurfacePoint point(const Spot& spot) const;

 private:
  struct Edge {
    int32_t triangle, corner;  // from this corner to the next
    int32_t next, before;      // edges of the same rim
    double length_mm;
  };
  const SurfaceView view_;
  std::vector<Edge> edge_;
};

}  // namespace limberg
