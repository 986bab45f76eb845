#pragma once
// What the plan foretold and what has come: at each point where tissue angles of sum S meet, q = 360 - S (figure.h).
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/commands/procedures/figure.h"
#include "sim/commands/script.h"
#include "sim/measure/skin_points.h"

namespace limberg {

/// A plan and where its points lie on the chart.
struct PlanOnSkin {
  Figure figure;
  std::function<ChartPoint(const Vec2& figure_mm)> chart;
  // False: its corners were read off the cuts. Its wounds and seams hold; there is nothing to compare the cuts with.
  bool named = false;
};

/// The plan that the script's header names; otherwise the Z or the rhombic flap that its
/// cuts draw (plan.h), with the corners as they were drawn; otherwise nothing. Keeps a
/// reference to the skin. InputError when the header's plan does not fit the skin.
std::optional<PlanOnSkin> plan_of(const Skin& skin, const std::optional<PlannedProcedure>& named,
                                  std::span<const Command> script);
/// Of a named procedure. InputError when there is none, or its values do not fit.
PlanOnSkin plan_on(const Skin& skin, const PlannedProcedure& named);

struct PredictedPoint {
  double q_deg = 0;
  ChartPoint at{0, 0};    // the first of the places that are sewn together here
  double reach_mm = 0;    // what counts for this point: half the way to the next one, 2 to 10 mm
  double height_mm = 0;   // highest skin above the original surface within reach of its places (skin_shape.h)
  double volume_mm3 = 0;  // above the original surface, within reach
  // 360 degrees less the angle that the skin closes round the point now: for each tissue sector, the length now of the
  // circle that lay at 0.8 reach around its corner, over its mean distance from the corner now. Stretch counts in it:
  // skin drawn in towards the point by 1 % lessens it by some 3.6 degrees. Nothing where a sector is cut or gone.
  std::optional<double> deficit_deg;
};

/// Of every charge of at least 20 degrees (smaller ones are spread along a curve and have no place of their own).
std::vector<PredictedPoint> predicted_points(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
                                             const SkinPoints& points, const PlanOnSkin& plan);

}  // namespace limberg
