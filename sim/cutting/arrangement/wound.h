#pragma once
// Where earlier cuts meet the skin, in the chart: what a new stroke can begin on, end on, or run along.
#include <vector>

#include "sim/cutting/strokes/blade_build.h"

namespace limberg {

struct WoundEdge {
  Vec2 a, b;  // chart, mm
};

class WoundMap {
 public:
  /// Junctions of live skin with walls, as they are now. Cost: the divided triangles of the skin.
  explicit WoundMap(const BladeContext& context);

  bool empty() const { return edge_.empty(); }
  std::span<const WoundEdge> edges() const { return edge_; }

  struct Near {
    Vec2 point = Vec2::Zero(), along = Vec2::UnitX();  // along: unit direction of the edge it lies on
    double distance = 1e300;
  };
  Near nearest(const Vec2& p) const;
  /// The first meeting of p -> q with a wound edge: parameter in [0, 1].
  std::optional<double> first_meeting(const Vec2& p, const Vec2& q) const;
  /// A place on a wound, moved along it when it lies within `clearance` of a free end: a blade that is to join a wall
  /// must cross it at every depth, and not pass beside its end.
  Vec2 clear_of_ends(const Vec2& p, double clearance) const;
  struct FreeEnd {
    Vec2 at, inward;  // unit, back along the wound
  };
  /// The free end nearest to p, if one is within reach.
  std::optional<FreeEnd> free_end_near(const Vec2& p, double reach) const;

 private:
  std::vector<WoundEdge> edge_;
  std::vector<FreeEnd> end_;
};

/// Is there still skin at this chart point? False over the hole of an excision and off the skin.
bool skin_is_live(const BladeContext& context, const ChartPoint& p);

}  // namespace limberg
