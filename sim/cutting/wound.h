#pragma once
// Where earlier cuts meet the skin, in the chart: what a new stroke can begin on, end on, or run along.
#include <vector>

#include "sim/cutting/blade_build.h"

namespace limberg {

struct WoundEdge {
  Vec2 a, b;           // chart, mm
};

class WoundMap {
 public:
  /// Junctions of live skin with walls, as they are now. Cost: the divided triangles of the skin.
  explicit WoundMap(const BladeContext& context);

  bool empty() const { return edge_.empty(); }
  std::span<const WoundEdge> edges() const { return edge_; }

  struct Near {
    Vec2 point = Vec2::Zero();
    double distance = 1e300;
  };
  Near nearest(const Vec2& p) const;
  /// The first meeting of p -> q with a wound edge: parameter in [0, 1] and the sine of the angle between them.
  struct Meeting {
    double s = 0, sine = 1;
  };
  std::optional<Meeting> first_meeting(const Vec2& p, const Vec2& q) const;

 private:
  std::vector<WoundEdge> edge_;
};

/// Is there still skin at this chart point? False over the hole of an excision and off the skin.
bool skin_is_live(const BladeContext& context, const ChartPoint& p);

}  // namespace limberg
