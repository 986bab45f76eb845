#pragma once
// How the banks of every seam lie against each other once it is sewn: beside each other and level, or one on the other.
//
// Stitches hold points of the skin together. They do so too where a flap lies on
// its neighbour, on its side or on its face; gaps, residual and forces are then
// as small as they should be. What tells is the tissue to both sides of a stitch.
#include "app/study/skin_map.h"

namespace limberg::study {

struct SeamsLie {
  int stitches = 0;  // looked at: all of the seams and the key stitches between corners
  // The angle at a stitch between the skin on one bank and on the other, 3 mm away
  // from the edge (less where the flap is narrower; along the bisector at a corner):
  // 180 degrees where it lies flat, 0 where one bank lies on the other. The least.
  double least_opening_deg = 180;
  // Edges at different heights: the part of the way from one edge
  // to the other that runs along the skin's normal there. The most.
  double most_step_mm = 0;
  // From a flap's corner to the corner that it was brought to. The most.
  double most_tip_mm = 0;
};

/// Of a figure whose origin is the chart's, stitched every
/// spacing_mm. A place whose skin is gone counts as an opening of 0.
SeamsLie seams_lie(const SkinMap& skin, const Figure& figure, double spacing_mm);

}  // namespace limberg::study
