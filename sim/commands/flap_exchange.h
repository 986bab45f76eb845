#pragma once
// How flaps that change places are carried: where their hooks go.
//
// Such flaps lie in each other's way: brought over together they meet edge to edge, and one comes to lie on its side.
// So all are folded back on their bases first. Then one after the other is laid over from above, is set down with its
// tip free in the opening, short of the corner, and is stitched before the next comes down beside it: the stitch draws
// the tip in. A tip that is pressed into the corner is jammed between its banks, in one of several ways that fractions
// of a millimetre decide, and lies where a needle meets something else.
#include <array>

#include "sim/geometry/vec.h"

namespace limberg {

/// In any unit of length.
struct ExchangedFlap {
  Vec2 base, grip, to;  // the base's middle; where the hook takes the flap; where it brings that
};

/// `end`: the corner that the tip goes to. It stops `short_of` before it; the hook holds it `hold` inside the tip.
inline ExchangedFlap exchanged_flap(const Vec2& base, const Vec2& grip, const Vec2& end, double hold, double short_of) {
  return {base, grip, end - (hold + short_of) * (end - base).normalized()};
}
inline constexpr double kShortOfCorner_mm = 1.5;  // with 60 degrees the tip then lies .75 mm from either bank

struct HookPlace {
  Vec2 at;
  double height_mm = 0;
};
/// Up, and over the base. `unit_mm`: the flap's unit of length.
inline std::array<HookPlace, 2> folded_back(const ExchangedFlap& f, double unit_mm) {
  const Vec2 way = f.grip - f.base;
  const double reach_mm = way.norm() * unit_mm;
  return {HookPlace{f.base + 0.6 * way, 0.7 * reach_mm}, HookPlace{f.base - 0.15 * way, 0.8 * reach_mm}};
}
inline constexpr double kLaidFrom_mm = 6, kLaidAt_mm = -0.3;  // heights of the hook

}  // namespace limberg
