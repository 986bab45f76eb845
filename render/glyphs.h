#pragma once
// Principal stretches of the skin, drawn as crosses on it: the long arm along the largest, the other along the least.
//
// Worked out from the surface alone: with the edges of a triangle at rest in the frame along and across the tension
// lines, E (2 x 2), and now, e (3 x 2), the gradient in the plane is F = e E^-1; the skin's prestretch F0 = diag(p, q)
// goes before it, and the stretches are the singular values of F F0. An arm is as long as the stretch: kFull of it
// fills the spacing; red where the skin is stretched, blue where it is pressed.
#include <vector>

#include "render/props.h"
#include "sim/patient/snapshot.h"

namespace limberg {

struct StretchGlyph {
  Vec3f at_mm, normal;
  Vec3f first, second;           // unit directions of the largest and of the least stretch, in the deformed skin
  float largest = 1, least = 1;  // principal stretches, prestretch included
};

inline constexpr float kFullStretch = 0.25f;  // stretch - 1 of an arm as long as the spacing

/// One for each square of the chart, `spacing_mm` wide, that has
/// skin: of the triangle nearest to its middle. Ordered by square.
std::vector<StretchGlyph> stretch_glyphs(const Snapshot& snapshot, double spacing_mm = 5);
void add_glyphs(PropMesh& mesh, const std::vector<StretchGlyph>& glyphs, double spacing_mm = 5);

}  // namespace limberg
