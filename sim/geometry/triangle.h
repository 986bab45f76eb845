#pragma once
// One triangle: its normal, its area and the point of it that is nearest to another.
#include <array>
#include <cmath>

#include "sim/geometry/vec.h"

namespace limberg {

/// Twice the area times the unit normal; outward for counter-clockwise triangles seen from outside.
inline Vec3 area_vector2(const Vec3& a, const Vec3& b, const Vec3& c) { return (b - a).cross(c - a); }

struct TrianglePoint {
  Vec3 point = Vec3::Zero();
  std::array<double, 3> bary{1, 0, 0};  // exact zeros name the feature: two zeros a corner, one zero an edge
};

/// The point of triangle abc nearest to p. Decides the Voronoi region by the signs of the projections on the edges
/// (corners first, then edges, then the face); a triangle without area is treated as its longest edges.
inline TrianglePoint closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {a, {1, 0, 0}};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {b, {0, 1, 0}};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 / (d1 - d3);
    return {a + t * ab, {1 - t, t, 0}};
  }
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {c, {0, 0, 1}};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 / (d2 - d6);
    return {a + t * ac, {1 - t, 0, t}};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {b + t * (c - b), {0, 1 - t, t}};
  }
  const double s = 1 / (va + vb + vc), v = vb * s, w = vc * s;
  return {a + v * ab + w * ac, {1 - v - w, v, w}};
}

/// Where a ray from `o` along `d` meets triangle abc: o + at d = (1 - u - v) a + u b + v c (Moeller and Trumbore 1997).
/// For one pass over a moving surface; Bvh::line is exact at edges and serves surfaces that are asked often.
template <class Point>
struct RayHitOf {
  typename Point::Scalar at = -1, u = 0, v = 0;
  bool met = false;
};
template <class Point>
RayHitOf<Point> meet_ray(const Point& o, const Point& d, const Point& a, const Point& b, const Point& c) {
  using Scalar = typename Point::Scalar;
  const Point e1 = b - a, e2 = c - a, p = d.cross(e2), from = o - a;
  const Scalar det = e1.dot(p);
  if (det == 0) return {};
  const Scalar u = from.dot(p) / det;
  if (!(u >= 0 && u <= 1)) return {};
  const Point q = from.cross(e1);
  const Scalar v = d.dot(q) / det, at = e2.dot(q) / det;
  return {at, u, v, v >= 0 && u + v <= 1 && at > 0};
}

}  // namespace limberg
