#pragma once
// What the body knows of places that a hand has touched, for who turns its gestures into commands: a chart sees a lip
// from the front only, and a stroke that goes right through does not say whether it ends at the lip's margin.
#include "sim/body/skin_view.h"

namespace limberg {

/// Whether the chart's place that finds the skin at `found` means the place X; all at rest, normals unit. A touched
/// place lies on a facet of the cut surface, which may run a little below the skin of the body. Of skin that is seen
/// too obliquely a hundredth of a millimetre on the chart may be a millimetre of a lip's margin.
inline bool chart_means(const Vec3& found_mm, const Vec3& normal, const Vec3& X_mm, const Vec3& chart_normal) {
  constexpr double kSame_mm = 0.5;
  return (found_mm - X_mm).norm() <= kSame_mm && normal.dot(chart_normal) >= kObliqueView;
}

class HandGround {
 public:
  virtual ~HandGround() = default;
  /// Whether the chart's place says enough: what a script finds there is the skin at X (at rest, mm).
  virtual bool chart_means(const ChartPoint& place, const Vec3& X_mm) const = 0;
  /// Out of the skin nearest to X, at rest, unit.
  virtual Vec3 normal(const Vec3& X_mm) const = 0;
  /// Whether the part of the body that a cut right through goes through ends close beyond X, on the way `way` (unit, at
  /// rest); `out`: unit, the way out of the skin along the blade.
  virtual bool margin_beyond(const Vec3& X_mm, const Vec3& out, const Vec3& way) const = 0;
};

}  // namespace limberg
