#pragma once
// A figure laid on the skin of any body: from the figure's plane to the rest surface and back to chart points.
//
// The figure's origin lies at a chart point, its +x axis along the direction that turn_deg makes with the chart's first
// axis, both in the skin's own tangent plane there. A point of the figure at distance r in direction u is where one
// arrives that walks r mm straight ahead on the surface in that direction (the exponential map), so lengths through the
// origin are true on any skin; across, they differ by the skin's curvature (r^3 / 6R^2 on a sphere of radius R). On a
// flat skin it is a turn and a shift. A straight line of the figure that does not pass through the origin is no
// straight line of the chart on a curved skin; line() follows it.
#include <vector>

#include "sim/body/skin.h"

namespace limberg {

struct Placement {
  ChartPoint origin{0, 0};
  double turn_deg = 0;    // counter-clockwise, seen from outside
  bool mirrored = false;  // y -> -y, before turning
};

class OnSkin {
 public:
  /// Walks need to know each triangle's neighbours: O(triangles) once. InputError when the origin lies off the skin.
  OnSkin(const Skin& skin, const Placement& placement);

  struct Spot {
    Vec3 X_mm, normal;  // rest surface; outward
    int triangle = -1;
  };
  /// InputError when the walk leaves the skin.
  Spot spot(const Vec2& figure_mm) const;
  /// The chart point that names that spot. InputError when another
  /// part of the skin lies over it, so that no chart point does.
  ChartPoint chart(const Vec2& figure_mm) const;
  /// Chart points after that of a, up to that of b: lines between them stray less
  /// than within_mm from where the figure's straight line comes to lie, as checked at
  /// the quarters of each, and none is divided below 1 mm. On a flat skin b's alone.
  std::vector<ChartPoint> line(const Vec2& a_mm, const Vec2& b_mm, double within_mm = 0.1) const;
  /// `height_mm` above the skin there, in the world.
  Vec3 above(const Vec2& figure_mm, double height_mm) const;

 private:
  void follow(const Vec2& a, const ChartPoint& at_a, const Vec2& b, const ChartPoint& at_b, double within_mm,
              std::vector<ChartPoint>& out) const;

  const Skin& skin_;
  Placement placement_;
  Spot origin_;
  Vec3 u_, v_;  // the figure's axes at the origin, unit, in the origin's triangle
  std::vector<std::array<int32_t, 3>>
      across_;  // per triangle: the skin triangle over edge k (corner k to k + 1), -1 at the skin's end
};

}  // namespace limberg
