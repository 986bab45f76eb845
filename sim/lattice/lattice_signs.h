#pragma once
// The few exact signs that decide how a surface lies in the lattice, free of ties.
//
// Every test is made with the lattice shifted by (-e1, -e2, -e3), e1 >> e2 >> e3 > 0 vanishing. A tie is then decided
// by the sign of the derivative with respect to the first e that matters, which has a closed form; nothing else is ever
// perturbed. Corners of walks need not be lattice corners, so corner coordinates are sub-units: half-units times 2^24.
// Bit budgets with |coordinate| < 2^22 half-units: plane at a corner 94 bits; order of two hits 140 bits; edge about
// a corner (2 * 162 + 2 * 24 + 1) = 373 bits.
#include "sim/geometry/exact/predicates.h"

namespace limberg {

inline constexpr int kSubUnitBits = 24;
/// A point in sub-units.
using SubPoint = std::array<int64_t, 3>;
inline double sub_to_half(int64_t s) { return double(s) * 0x1p-24; }  // exact: 46 bits

/// Index of the lattice layer along `axis` that holds p: the largest i with p >= origin + i * pitch.
int32_t layer_of(const PointRef& p, int axis, int32_t origin, int32_t pitch);

/// Sides of the directed edge p -> q seen along `axis` (from its positive end; first coordinate (axis + 1) % 3, second
/// (axis + 2) % 3): +1 when the corner is to its left. 0 only when the edge is parallel to the axis.
int edge_about_corner(const PointRef& p, const PointRef& q, int axis, const SubPoint& corner);

/// The same for the twelve lattice edges of a cell: bit 0 of the corner the high bound of the first coordinate, bit 1
/// that of the second. Of the edge in the other sense they are the opposite.
struct EdgeSigns {
  uint16_t left = 0, right = 0;  // bit 4 axis + corner: the corner lies there
  int of(int axis, int corner) const {
    return int(left >> (4 * axis + corner) & 1) - int(right >> (4 * axis + corner) & 1);
  }
  /// Do all four lattice edges along some axis lie on one side of it?
  bool misses_all() const {
    const auto four = [](uint32_t b) { return (b & b >> 1 & b >> 2 & b >> 3 & 0x111) != 0; };
    return four(left) || four(right);
  }
};
struct CellBounds {
  std::array<std::array<double, 2>, 3> half;             // half-units, [axis][high]; whole numbers
  std::array<std::array<SubPoint, 4>, 3> edge_corner{};  // low ends of the lattice edges, [axis][corner]
};
/// `parallel`: the axis that the edge is known to be parallel
/// to, or -1. (That is found without it, too, but costs more.)
EdgeSigns edge_about_corners(const PointRef& p, const PointRef& q, int parallel, const CellBounds& cell);

/// Sign of n . corner - d.
int plane_at_corner(const Plane& plane, const SubPoint& corner);

/// Orders the points where the line through `on_line` along `axis` meets planes a and b (neither parallel to it):
/// -1 when a comes first. 0 only for one and the same plane.
int order_on_line(const Plane& a, const Plane& b, int axis, const SubPoint& on_line);

/// That point's coordinate along the axis, half-units.
double hit_on_line(const Plane& plane, int axis, const SubPoint& on_line);

}  // namespace limberg
