#pragma once
// Numbers of plans: turned points, and coordinates as scripts state them.
#include <cmath>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// Unit vector at an angle, counter-clockwise from +x.
inline Vec2 direction(double deg) {
  return {elementary::cos(deg * std::numbers::pi / 180), elementary::sin(deg * std::numbers::pi / 180)};
}

/// Turned counter-clockwise about the origin.
inline Vec2 turned(const Vec2& p, double deg) {
  const Vec2 u = direction(deg);
  return {u.x() * p.x() - u.y() * p.y(), u.y() * p.x() + u.x() * p.y()};
}

/// To 1/1000; no minus zero.
inline double rounded(double v) {
  const double r = std::round(v * 1000) / 1000;
  return r == 0 ? 0 : r;
}

/// Equal parts of an edge between stitches, about so far apart: a
/// row has a stitch more with those at both ends, one less without.
inline double parts_of_row(double length_mm, double spacing_mm) { return std::floor(length_mm / spacing_mm + 0.5); }

}  // namespace limberg
