#pragma once
// Paths and polygons given by their corners: length, area, inside, nearest and crossing segments, simplification.
#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// The length of a path through points of the plane or of space; none for fewer than two points.
template <class Points>
double path_length(const Points& path) {
  double length = 0;
  for (size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  return length;
}

/// Positive for a polygon that runs counter-clockwise.
double signed_area(std::span<const Vec2> polygon);

/// By the crossing rule, which holds for polygons that meet themselves too; a point on an edge may be either.
bool inside_polygon(std::span<const Vec2> polygon, const Vec2& p);

/// The distance of p from segment ab, in the plane or in space; a and b may be one point.
template <class Point>
auto distance_to_segment(const Point& p, const Point& a, const Point& b) {
  using Scalar = typename Point::Scalar;
  const Point d = b - a;
  const Scalar l = d.squaredNorm();
  const Scalar t = l > 0 ? std::clamp((p - a).dot(d) / l, Scalar(0), Scalar(1)) : Scalar(0);
  return (p - a - t * d).norm();
}
inline double distance_to_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  return distance_to_segment<Vec2>(p, a, b);
}

/// Where segment p-q (parameter s in [0, 1]) meets segment a-b; empty when they do not meet or are parallel.
std::optional<double> meet_segments(const Vec2& p, const Vec2& q, const Vec2& a, const Vec2& b);

/// Marks, between the kept points `first` and `last`, every point that lies farther than `tolerance` from the line
/// between its kept neighbours (Douglas and Peucker 1973). Its own stack: paths may be of any length.
void keep_corners(std::span<const Vec2> path, size_t first, size_t last, double tolerance, std::span<uint8_t> keep);

/// The path with only the corners that keep_corners() finds; first and last points stay.
std::vector<Vec2> simplify(std::span<const Vec2> path, double tolerance);
std::vector<Vec3> simplify(std::span<const Vec3> path, double tolerance);

}  // namespace limberg
