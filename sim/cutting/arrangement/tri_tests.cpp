#include "sim/cutting/arrangement/tri_tests.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace limberg {

namespace {

// Orientation of three integer points projected along the axis `drop`.
int turn(int drop, const Int3& a, const Int3& b, const Int3& c) {
  const int i = (drop + 1) % 3, j = (drop + 2) % 3;
  const int64_t d = (int64_t(b[i]) - a[i]) * (int64_t(c[j]) - a[j]) - (int64_t(b[j]) - a[j]) * (int64_t(c[i]) - a[i]);
  return d > 0 ? 1 : d < 0 ? -1 : 0;
}

// p and triangle t lie in one plane (seen along `drop`): is p in the closed triangle?
bool in_closed(int drop, const Int3& p, const std::array<Int3, 3>& t) {
  const int s0 = turn(drop, t[0], t[1], p), s1 = turn(drop, t[1], t[2], p), s2 = turn(drop, t[2], t[0], p);
  return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
}

// Sign of (p - v) . (q - v) projected along the axis `drop`.
int heading(int drop, const Int3& v, const Int3& p, const Int3& q) {
  const int i = (drop + 1) % 3, j = (drop + 2) % 3;
  const int64_t d = (int64_t(p[i]) - v[i]) * (int64_t(q[i]) - v[i]) + (int64_t(p[j]) - v[j]) * (int64_t(q[j]) - v[j]);
  return d > 0 ? 1 : d < 0 ? -1 : 0;
}

// Two coplanar triangles that share `shared` vertices by name.
bool coplanar_meet(int drop, const IntTriangle& s, const IntTriangle& t, int shared) {
  // A line through an edge of one that has the other beyond it separates them. Shared vertices lie on it; with one
  // shared vertex another may lie on it too, on the far side of the shared one.
  const auto separates = [&](const IntTriangle& x, const IntTriangle& y) {
    for (size_t k = 0; k < 3; ++k) {
      const size_t l = (k + 1) % 3;
      const int own = turn(drop, x.p[k], x.p[l], x.p[(k + 2) % 3]);
      bool ok = own != 0;
      int on_line = 0;
      size_t apex = k;
      for (size_t m = 0; m < 3; ++m)
        if (y.id[m] == x.id[k] || y.id[m] == x.id[l]) ++on_line, apex = y.id[m] == x.id[k] ? k : l;
      for (size_t m = 0; m < 3 && ok; ++m) {
        if (y.id[m] == x.id[k] || y.id[m] == x.id[l]) continue;
        const int side = turn(drop, x.p[k], x.p[l], y.p[m]);
        const bool behind = side == 0 && shared == 1 && heading(drop, x.p[apex], x.p[apex == k ? l : k], y.p[m]) < 0;
        ok = side == -own || behind;
      }
      if (ok && on_line == shared) return true;
    }
    return false;
  };
  return !separates(s, t) && !separates(t, s);
}

// Does edge k of s meet the closed triangle t elsewhere than in shared vertices? side: of s's corners against t's
// plane; they are not all zero.
bool edge_meets(const IntTriangle& s, size_t k, const std::array<int, 3>& side, const IntTriangle& t, int drop) {
  const size_t l = (k + 1) % 3;
  const auto shared = [&](size_t c) { return s.id[c] == t.id[0] || s.id[c] == t.id[1] || s.id[c] == t.id[2]; };
  const Int3 &p = s.p[k], &q = s.p[l];
  if (side[k] == 0 && side[l] == 0) {  // the edge lies in the plane of t
    if (shared(k) && shared(l)) return false;
    if (!shared(k) && in_closed(drop, p, t.p)) return true;
    if (!shared(l) && in_closed(drop, q, t.p)) return true;
    for (size_t m = 0; m < 3; ++m) {
      const size_t n = (m + 1) % 3;
      // Against an edge of t that holds the shared vertex: only an overlap along the same line could be more.
      const bool touches = t.id[m] == s.id[k] || t.id[m] == s.id[l] || t.id[n] == s.id[k] || t.id[n] == s.id[l];
      const int a = turn(drop, p, q, t.p[m]), b = turn(drop, p, q, t.p[n]);
      const int c = turn(drop, t.p[m], t.p[n], p), d = turn(drop, t.p[m], t.p[n], q);
      if (touches) continue;
      if (a == 0 && b == 0 && c == 0 && d == 0) {  // all in one line: they may lie behind each other
        if (heading(drop, t.p[m], p, q) <= 0 || heading(drop, t.p[n], p, q) <= 0) return true;
        continue;
      }
      if (a * b <= 0 && c * d <= 0) return true;
    }
    // From a shared vertex into the inside of t and out through the far edge is caught above (far edge crossed); ending
    // inside too. Running along an edge of t from the shared vertex: the other end or the far vertex lies on it.
    for (size_t c : {k, l}) {
      if (!shared(c)) continue;
      const size_t other = c == k ? l : k;
      for (size_t m = 0; m < 3; ++m) {
        if (t.id[m] == s.id[c] || turn(drop, s.p[c], s.p[other], t.p[m]) != 0) continue;
        if (heading(drop, s.p[c], s.p[other], t.p[m]) > 0) return true;
      }
    }
    return false;
  }
  if (side[k] == 0) return !shared(k) && in_closed(drop, p, t.p);
  if (side[l] == 0) return !shared(l) && in_closed(drop, q, t.p);
  if (side[k] == side[l]) return false;
  int plus = 0, minus = 0;
  for (size_t m = 0; m < 3; ++m) {
    const int o = orient3d(p, q, t.p[m], t.p[(m + 1) % 3]);
    plus += o > 0;
    minus += o < 0;
  }
  return plus == 0 || minus == 0;
}

}  // namespace

bool meet_beyond_shared(const IntTriangle& s, const IntTriangle& t) {
  return meet_beyond_shared(s, plane_through(s.p[0], s.p[1], s.p[2]), t, plane_through(t.p[0], t.p[1], t.p[2]));
}

bool meet_beyond_shared(const IntTriangle& s, const Plane& ps, const IntTriangle& t, const Plane& pt) {
  int shared = 0;
  size_t other = 0;
  for (size_t i = 0; i < 3; ++i) {
    const bool known = s.id[i] == t.id[0] || s.id[i] == t.id[1] || s.id[i] == t.id[2];
    shared += known;
    if (!known) other = i;
  }
  if (shared == 3) return true;
  // Two different planes through a common edge: nothing but the common line.
  if (shared == 2 && side_of_plane(pt, s.p[other]) != 0) return false;
  std::array<int, 3> side_s, side_t;
  int plus = 0, minus = 0;
  for (size_t i = 0; i < 3; ++i) {
    side_s[i] = side_of_plane(pt, s.p[i]);
    plus += side_s[i] > 0;
    minus += side_s[i] < 0;
  }
  if (plus == 3 || minus == 3) return false;
  if (plus == 0 && minus == 0) return coplanar_meet(projection_axis(pt), s, t, shared);
  if (shared == 2) return false;  // two different planes: nothing but the common line
  plus = minus = 0;
  for (size_t i = 0; i < 3; ++i) {
    side_t[i] = side_of_plane(ps, t.p[i]);
    plus += side_t[i] > 0;
    minus += side_t[i] < 0;
  }
  if (plus == 3 || minus == 3) return false;
  for (size_t k = 0; k < 3; ++k)
    if (edge_meets(s, k, side_s, t, projection_axis(pt)) || edge_meets(t, k, side_t, s, projection_axis(ps)))
      return true;
  return false;
}

namespace {

// The sides of a triangle's corners against a plane: -1 all on one, 0 a coincidence, +1 straddling.
int classify(const std::array<int, 3>& x) {
  const int plus = (x[0] > 0) + (x[1] > 0) + (x[2] > 0), minus = (x[0] < 0) + (x[1] < 0) + (x[2] < 0);
  return plus == 3 || minus == 3 ? -1 : plus + minus < 3 ? 0 : 1;
}

// Of a straddling triangle: its two edges through the plane, ascending. They meet in the corner that is alone.
std::array<size_t, 2> straddling_edges(const std::array<int, 3>& side) {
  if (side[0] == side[1]) return {1, 2};
  return side[0] == side[2] ? std::array<size_t, 2>{0, 1} : std::array<size_t, 2>{0, 2};
}

}  // namespace

SlantBox slant_box(const IntBox& box, std::span<const IntTriangle> triangle, std::span<const Plane> plane) {
  Vec3 sum = Vec3::Zero();
  for (const Plane& p : plane) sum += Vec3(double(p.n[0]), double(p.n[1]), double(p.n[2]));
  const Eigen::Vector3f n = sum.normalized().cast<float>();
  double lo = HUGE_VAL, hi = -HUGE_VAL;
  for (const IntTriangle& t : triangle)
    for (const Int3& p : t.p) {
      const double at = 2 * (double(n.x()) * p.x + double(n.y()) * p.y + double(n.z()) * p.z);
      lo = std::min(lo, at), hi = std::max(hi, at);
    }
  return {box, {n.x(), n.y(), n.z()}, float(lo) - SlantBox::kRoom, float(hi) + SlantBox::kRoom};
}

Crossing cross_triangles(const IntTriangle& s, const Plane& plane_s, const IntTriangle& t, const Plane& plane_t) {
  Crossing result;
  std::array<int, 3> ss, st;
  for (size_t i = 0; i < 3; ++i)
    st[i] = side_of_plane(plane_s, t.p[i]);  // mostly tells them apart: blades stand upright
  const int ct = classify(st);
  if (ct < 0) return result;
  for (size_t i = 0; i < 3; ++i) ss[i] = side_of_plane(plane_t, s.p[i]);
  const int cs = classify(ss);
  if (cs < 0) return result;
  if (cs == 0 || ct == 0) {
    result.kind = Crossing::coincidence;
    return result;
  }
  // Both straddle the other's plane, so each has two edges that cross it. An edge of s meets the plane of t on the line
  // that both planes share; it is inside t when that place lies between t's two crossing edges. On which side of one of
  // them it lies is the sign of a volume, which is that of the two edges whichever is asked about the other: four signs
  // tell all. The third edge of t need not be asked: the common line does not meet it.
  const auto es = straddling_edges(ss), et = straddling_edges(st);
  int o[2][2];
  for (size_t i = 0; i < 2; ++i)
    for (size_t j = 0; j < 2; ++j)
      o[i][j] = orient3d(s.p[es[i]], s.p[(es[i] + 1) % 3], t.p[et[j]], t.p[(et[j] + 1) % 3]);
  if (o[0][0] * o[0][1] * o[1][0] * o[1][1] == 0) {
    result.kind = Crossing::coincidence;
    return result;
  }
  size_t ends = 0;
  const auto end = [&](bool of_s, size_t edge) {
    if (ends < 2) result.end[ends] = {of_s, int(edge)};
    ++ends;
  };
  for (size_t i = 0; i < 2; ++i)
    if (o[i][0] == o[i][1]) end(true, es[i]);
  for (size_t j = 0; j < 2; ++j)
    if (o[0][j] == o[1][j]) end(false, et[j]);
  if (ends == 2) result.kind = Crossing::crossing;
  if (ends > 2) result.kind = Crossing::coincidence;  // cannot happen
  return result;
}

Crossing cross_triangles_exactly(const IntTriangle& s, const Plane& plane_s, const IntTriangle& t,
                                 const Plane& plane_t) {
  Crossing result;
  std::array<int, 3> ss, st;
  for (size_t i = 0; i < 3; ++i) ss[i] = side_of_plane(plane_t, s.p[i]);
  const int cs = classify(ss);
  if (cs < 0) return result;
  for (size_t i = 0; i < 3; ++i) st[i] = side_of_plane(plane_s, t.p[i]);
  const int ct = classify(st);
  if (ct < 0) return result;
  if (cs == 0 || ct == 0) {
    result.kind = Crossing::coincidence;
    IntTriangle a = s, b = t;  // without common names: closed triangles
    a.id = {0, 1, 2};
    b.id = {3, 4, 5};
    if (!meet_beyond_shared(a, b)) {
      result.kind = Crossing::apart;
      return result;
    }
    // They meet. If every vertex in the other's plane lies off the other triangle, what is left is in general position.
    const auto touches = [](const IntTriangle& x, const std::array<int, 3>& side, const IntTriangle& y,
                            const Plane& p) {
      int zeros = 0;
      for (size_t i = 0; i < 3; ++i)
        if (side[i] == 0 && (++zeros > 1 || in_closed(projection_axis(p), x.p[i], y.p))) return true;
      return false;
    };
    if (touches(s, ss, t, plane_t) || touches(t, st, s, plane_s)) return result;
    result.kind = Crossing::apart;
  }
  // Does the edge k of x, which straddles y's plane, pass through y? 1 yes, 0 no, -1 coincidence.
  const auto through = [](const IntTriangle& x, size_t k, const IntTriangle& y) {
    int plus = 0, minus = 0;
    for (size_t m = 0; m < 3; ++m) {
      const int o = orient3d(x.p[k], x.p[(k + 1) % 3], y.p[m], y.p[(m + 1) % 3]);
      plus += o > 0;
      minus += o < 0;
    }
    if (plus > 0 && minus > 0) return 0;
    return plus + minus == 3 ? 1 : -1;
  };
  size_t ends = 0;
  for (int own = 1; own >= 0; --own)
    for (size_t k = 0; k < 3; ++k) {
      const auto& side = own ? ss : st;
      if (side[k] * side[(k + 1) % 3] >= 0) continue;
      const int r = own ? through(s, k, t) : through(t, k, s);
      if (r < 0 || (r > 0 && ends == 2)) {
        result.kind = Crossing::coincidence;
        return result;
      }
      if (r > 0) result.end[ends++] = {own == 1, int(k)};
    }
  if (ends == 2) result.kind = Crossing::crossing;
  if (ends == 1 || (ends == 0 && (cs == 0 || ct == 0)))
    result.kind = Crossing::coincidence;  // cannot happen without an exact zero
  return result;
}

}  // namespace limberg
