#pragma once
// What of a hand-drawn stroke was meant as a curve: a bend is told from a corner, and the points between corners become
// a smooth line. An arc left to the polygon of its corners would be cut half a millimetre beside where it was drawn.
#include <cstddef>
#include <span>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// A stroke by its length: means over half a millimetre each of the points that lie beside a polygon, so that a hand
/// that waits weighs no more than one that moves.
struct Course {
  std::vector<double> s_mm;  // along the polygon, rising
  std::vector<Vec2> at;      // chart mm
  std::vector<double> knot;  // where the polygon's corners lie, s_mm
};

/// `knots`: indices of the polygon's corners among `points`, rising, the first and the last point among them.
Course course_of(std::span<const Vec2> points, std::span<const size_t> knots);

/// Whether the course bends at its k-th knot (not an end) along a parabola rather than in a corner between two straight
/// edges: whichever leaves the smaller sum of squares over both edges (8 mm each at most), the corner put where it does
/// best within a millimetre. Knots lie on the waves of tremor, so that corners fit those: a turn of less than 75
/// degrees is a corner only where the parabola leaves more than tremor, .35 of the tolerance in the mean square, and
/// twice as much as the corner. A corner when there are too few points to tell, or it turns by more than 110 degrees.
bool bends_at(const Course&, size_t k, double tolerance_mm);

/// Whether the edge from the k-th knot to the next is an arc: a parabola through its points rises by more than
/// `tolerance_mm` and leaves less than half of a line's sum of squares.
bool is_arc(const Course&, size_t k, double tolerance_mm);

struct DrawnCurve {
  std::vector<Vec2> at;  // within an eighth of the tolerance of the curve; the first and last are its ends
  Vec2 tangent_at_begin, tangent_at_end;  // along the stroke, of length one
};

/// From knot a to knot b: a cubic B-spline by least squares (de Boor, A Practical Guide to Splines, chapter XIV), of so
/// many equal spans (1, 2, 4 ...) that a quarter of the tolerance is left in the mean square, none below 4 mm. Empty:
/// too few points. O(points)
DrawnCurve drawn_curve(const Course&, size_t a, size_t b, double tolerance_mm);

}  // namespace limberg
