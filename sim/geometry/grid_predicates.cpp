#include "sim/geometry/grid_predicates.h"

#include <algorithm>
#include <cstdlib>

namespace limberg {
namespace {

int sign(GridVolume v) { return (v > 0) - (v < 0); }

struct P2 {
  int64_t x, y;
};
int orient2d(const P2& a, const P2& b, const P2& c) {  // 44-bit products: exact in 64 bits
  const int64_t d = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  return (d > 0) - (d < 0);
}
bool on_segment(const P2& a, const P2& b, const P2& p) {  // p on line ab assumed
  return std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
         p.y <= std::max(a.y, b.y);
}
bool segments_meet(const P2& a, const P2& b, const P2& c, const P2& d) {
  const int s = orient2d(a, b, c), t = orient2d(a, b, d), u = orient2d(c, d, a), v = orient2d(c, d, b);
  if (s * t < 0 && u * v < 0) return true;
  return (s == 0 && on_segment(a, b, c)) || (t == 0 && on_segment(a, b, d)) || (u == 0 && on_segment(c, d, a)) ||
         (v == 0 && on_segment(c, d, b));
}
bool in_triangle(const std::array<P2, 3>& t, const P2& p) {
  const int a = orient2d(t[0], t[1], p), b = orient2d(t[1], t[2], p), c = orient2d(t[2], t[0], p);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

// Drop the axis along which the plane is seen best.
int dropped_axis(const GridTriangle& t) {
  const auto n = grid_normal(t[0], t[1], t[2]);
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(n[size_t(k)]) > std::abs(n[size_t(axis)])) axis = k;
  return axis;
}
P2 flat(const Int3& p, int axis) { return axis == 0 ? P2{p.y, p.z} : axis == 1 ? P2{p.z, p.x} : P2{p.x, p.y}; }

}  // namespace

bool grid_segment_meets_triangle(const Int3& p, const Int3& q, const GridTriangle& t) {
  const int sp = sign(grid_orient3d(t[0], t[1], t[2], p)), sq = sign(grid_orient3d(t[0], t[1], t[2], q));
  if (sp * sq > 0) return false;
  if (sp == 0 && sq == 0) {
    const int axis = dropped_axis(t);
    const std::array<P2, 3> f{flat(t[0], axis), flat(t[1], axis), flat(t[2], axis)};
    const P2 a = flat(p, axis), b = flat(q, axis);
    if (in_triangle(f, a) || in_triangle(f, b)) return true;
    for (size_t k = 0; k < 3; ++k)
      if (segments_meet(a, b, f[k], f[(k + 1) % 3])) return true;
    return false;
  }
  // The line pq meets the plane in one point, on the segment; is that point inside?
  int lo = 0, hi = 0;
  for (size_t k = 0; k < 3; ++k) {
    const int s = sign(grid_orient3d(p, q, t[k], t[(k + 1) % 3]));
    lo = std::min(lo, s);
    hi = std::max(hi, s);
  }
  return lo * hi == 0;
}

bool grid_triangles_offend(const GridTriangle& a, const GridTriangle& b) {
  std::array<int, 3> twin{-1, -1, -1};  // corner of b that equals corner i of a
  int shared = 0;
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      if (a[i] == b[j]) twin[i] = int(j), ++shared;
  if (shared == 3) return true;
  if (shared == 2) {  // only a fold onto itself can go wrong
    size_t i = 0;
    while (twin[i] >= 0) ++i;
    const size_t j = size_t(3 - twin[(i + 1) % 3] - twin[(i + 2) % 3]);
    if (grid_orient3d(a[0], a[1], a[2], b[j]) != 0) return false;
    const int axis = dropped_axis(a);
    const P2 u = flat(a[(i + 1) % 3], axis), v = flat(a[(i + 2) % 3], axis);
    return orient2d(u, v, flat(a[i], axis)) == orient2d(u, v, flat(b[j], axis));
  }
  if (shared == 1) {
    // More than the corner in common means that the edge opposite the corner in one meets the other: the common part
    // is convex, holds the corner, and its far end lies on one of those two edges.
    size_t i = 0;
    while (twin[i] < 0) ++i;
    const size_t j = size_t(twin[i]);
    return grid_segment_meets_triangle(a[(i + 1) % 3], a[(i + 2) % 3], b) ||
           grid_segment_meets_triangle(b[(j + 1) % 3], b[(j + 2) % 3], a);
  }
  for (size_t k = 0; k < 3; ++k)
    if (grid_segment_meets_triangle(a[k], a[(k + 1) % 3], b) || grid_segment_meets_triangle(b[k], b[(k + 1) % 3], a))
      return true;
  return false;
}

}  // namespace limberg
