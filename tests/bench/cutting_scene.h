#pragma once
// What `bench cutting` cuts, and with what.
//
// The slab: 200 x 200 x 20 mm, closed, with a wavy skin of cells x cells squares of two triangles. Sides are one row of
// triangles, the bottom is a fan, so that almost all triangles are skin: cells = 112, 224, 448, 896 give 26 k, 103 k,
// 407 k and 1.6 M triangles. Sides and bottom are held.
// The blade: an upright strip under an S-shaped curve 120 mm long, 1 mm above the skin to 9 mm below it, in 100 columns
// of two triangles. Its middle lies off the lines of the skin's mesh: a coincidence would cost ours a second try.
#include "sim/body/body.h"
#include "sim/cutting/strokes/blade.h"

namespace limberg::bench {

Body wavy_slab(int cells);

struct BladePlace {
  Vec2 middle{0.37, 0.21};
  double angle_deg = 0;
  double length_mm = 120;
  double depth_mm = 9;
  int columns = 100;
  double bend_mm = 6;  // how far the curve swings to either side
};
Blade curved_blade(const Body& body, const BladePlace& place);

}  // namespace limberg::bench
