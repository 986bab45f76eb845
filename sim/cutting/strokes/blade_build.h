#pragma once
// Blades from strokes: the drawn line on the skin becomes an embedded triangle surface in rest space.
//
// Conventions that make operations meet each other reliably (mm, measured along the smoothed skin normal):
//   plug floor          at the depth asked
//   incision bottom     kWallExtra below the depth asked (varied by up to 0.04 from cut to cut, so that fronts never
//   coincide) undermining sheet   kSheetRaise above the depth asked
// so an undermining at the same depth as an incision or a plug always runs into their walls, never into their fronts.
// Blades stick out of the skin by kMargin; a stroke that ends on or near an earlier cut is pushed kOvershoot through
// its wall. What sticks out or is pushed through is never a seed.
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "sim/body/body.h"
#include "sim/body/skin_view.h"
#include "sim/cutting/arrangement/arrangement.h"

namespace limberg {

class Skin;

inline constexpr double kWallExtra = 0.15, kSheetRaise = 0.15, kOvershoot = 0.1, kMargin = 1.0;
inline constexpr double kSnap = 0.5;     // a stroke that ends this near to an earlier cut is meant to end on it
inline constexpr double kSpacing = 1.5;  // along a stroke
inline constexpr double kSheetSpacing = 2.0;

/// Where on the rest skin is this chart point? (Body::chart; sim/geometry answers it.) Empty when it is off the skin.
using SkinQuery = std::function<std::optional<SkinHit>(const ChartPoint&)>;

/// The deformation gradient of the tissue under a point of the rest skin, as it lies now. The angle between blade and
/// skin is held in that state and pulled back (pull_back.h); depths always count layers of tissue at rest.
using GradientQuery = std::function<Mat3(const SkinHit&)>;

/// A blade, or why there is none.
struct BladeResult {
  std::optional<Blade> blade = {};
  std::string reason = {};
  bool nothing = false;  // not refused: there is nothing there that is not cut already
  bool folds = false;    // refused because the blade would run through itself: its parts might not
};

struct BladeContext {
  const Body* body = nullptr;
  const Arrangement* arrangement = nullptr;  // for T-junctions
  SkinQuery skin;
  GradientQuery gradient = {};  // empty: the skin lies as at rest
  // How an act at places in space looks at the skin; null: from the front, on the body's chart.
  const SkinView* view = nullptr;

  Chart chart() const { return view ? view->chart : body->chart(); }
  /// Whether a place of the skin belongs to what is seen.
  bool shows(const Vec3& X_mm, const Vec3& normal) const { return !view || view->shows(X_mm, normal); }
};

/// Walls and floor under a closed outline as one open box: what excision cuts. The outline need not repeat its first
/// point.
BladeResult build_plug(const BladeContext& context, std::span<const ChartPoint> outline, double depth_mm);

/// A blade through the body from one side to the other, through the places of context.view: columns along the normals
/// (out of the skin, one for each place; none: those of the skin), even between two of them, from above the skin to
/// beyond the other side, which is the first way out along each. An open end goes on over the body's free margin; a
/// closed one that lies beside an earlier cut is pushed through its wall. `skin` is that of the body.
struct ThroughCut {
  std::span<const Vec3> normals = {};
  bool open_start = false, open_end = false;
  // Not empty: the cut begins at these places on the bed of an earlier pocket, one for each of context.view, and leaves
  // the tissue above it whole.
  std::span<const Vec3> on_bed = {};
};
BladeResult build_through(const BladeContext& context, const Skin& skin, const ThroughCut& cut);

/// A sheet under an outline. Where the outline runs along an earlier cut it is widened beyond its wall. Along what is
/// held: where the body's held surface lies nearer below the skin than the depth, the sheet lies `above_mm` above it,
/// and falls off from there no steeper than kSlope. Refused where nothing is held within the depth.
struct AlongHeld {
  const Skin* skin = nullptr;  // that of the body; null: at one depth
  double above_mm = 0.5;
};
BladeResult build_undermining(const BladeContext& context, std::span<const ChartPoint> outline, double depth_mm,
                              const AlongHeld& held = {});

}  // namespace limberg
