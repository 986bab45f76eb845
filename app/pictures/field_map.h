#pragma once
// A figure of every place of the skin, drawn on the chart at rest.
#include <span>
#include <string>

#include "app/words/words.h"
#include "sim/body/body.h"
#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

struct FieldMap {
  std::string title, unit;
  double lo = 0, hi = 1;     // of the scale: ten steps from light to dark
  bool dark_is_low = false;  // what is to be seen is where the figure is small
  Words w{};                 // of its figures
};

/// An SVG picture, y up, in squares of a 160th of what is shown: what lies within 25 mm of a cut, or all skin where
/// nothing is cut. Cuts are drawn as they lie at rest, with a scale of 10 mm. `value`: per triangle of the view; what
/// is no skin, or not finite, or below `nothing`, is left out.
std::string field_map_svg(const SurfaceView& view, const Body& body, std::span<const float> value, const FieldMap& map,
                          double nothing = -0.5);

}  // namespace limberg
