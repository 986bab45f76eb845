#pragma once
// How an act looks at the skin when its places are given in space: a chart of its own, laid where the act is.
//
// The body's chart sees a face from the front, outermost first; the back of a lip, the margin of a lid and the far side
// of a head it does not see. A view lies in the plane of the act's own places, seen from outside the skin there, and of
// several sheets of skin below one another it means the one nearest to the places.
//
//   std::string reason;
//   const auto view = view_of(skin, places, reason);       // for cuts: a plane
//   const auto hit = skin.at(view->chart.to_chart(view->place[i]), *view);
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/body/chart.h"

namespace limberg {

class Skin;

struct SkinView {
  Chart chart;              // normal: the mean of the skin's, outwards
  std::vector<Vec3> place;  // those of the act, on the skin, mm

  /// Of the skin that is meant, above the chart's plane: of the places, the nearer the more (inverse distance, 1/d^4).
  double height_mm(const ChartPoint& p) const;
  /// Whether a place of the skin with this normal belongs to what the view shows: it faces the viewer and lies within
  /// kViewDepth_mm of the height there.
  bool shows(const Vec3& X_mm, const Vec3& normal) const;
};

inline constexpr double kViewDepth_mm = 8;  // less than a lip is thick from skin to mucosa (some 8 to 12 mm)
inline constexpr double kOffSkin_mm = 5;    // a place in space may lie so far off the skin
/// Cosine between the view and the skin at a place. More oblique, a chart of one plane stretches paths fivefold.
inline constexpr double kObliqueView = 0.2;

/// "(1.00, 2.00, 3.00) mm"
std::string at_text(const Vec3& X_mm);

/// Where on the skin a place in space is meant; nothing, with a reason, when it lies off it.
std::optional<Vec3> place_on_skin(const Skin& skin, const Vec3& X_mm, std::string& reason);

/// The view of an act at these places, at least one; nothing, with a reason, when one lies off the skin, or the skin
/// turns too far between them.
std::optional<SkinView> view_of(const Skin& skin, std::span<const Vec3> places, std::string& reason);

}  // namespace limberg
