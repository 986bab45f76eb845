#include "devices/surface_walk.h"

#include <algorithm>
#include <cmath>

#include "sim/geometry/triangle.h"

namespace limberg {

namespace {

constexpr double kZero = 1e-12;  // of a barycentric coordinate: on the edge

Vec3 at(const Snapshot& s, int32_t v) { return s.x_mm[size_t(v)].cast<double>(); }

int corner_of(const Tri& k, int32_t v) { return k[0] == v ? 0 : k[1] == v ? 1 : k[2] == v ? 2 : -1; }

}  // namespace

/// A way onward: in which triangle, from where in it, and how fast its coordinates change when all of d is used.
struct SurfaceWalk::Way {
  int32_t triangle = -1;
  std::array<double, 3> bary{}, rate{};
  double length = -1;  // of the way that d makes there
};

int32_t SurfaceWalk::beyond(const Snapshot& s, int32_t t, int k) const {
  const auto& tri = s.topology->view.tri;
  const Tri& own = tri[size_t(t)];
  const int32_t a = own[size_t((k + 1) % 3)], b = own[size_t((k + 2) % 3)];
  int32_t any = -1;
  for (const int32_t u : of(s).around(a)) {
    if (u == t) continue;
    const int at_b = corner_of(tri[size_t(u)], b);
    if (at_b < 0) continue;
    if (tri[size_t(u)][size_t((at_b + 1) % 3)] == a)
      return u;  // runs the edge the other way: the same side of the surface
    any = u;
  }
  return any;
}

bool SurfaceWalk::sliver(const Snapshot& s, int32_t t) const {
  const Tri& k = s.topology->view.tri[size_t(t)];
  const Vec3 a = at(s, k[0]), b = at(s, k[1]), c = at(s, k[2]);
  const double longest2 = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return area_vector2(a, b, c).norm() <= kSliver * longest2;
}

/// A sliver entered over an edge is left over the other edge that the place lies on. False: there is nothing beyond.
bool SurfaceWalk::cross_slivers(const Snapshot& s, const Vec3& x, int32_t& t, std::array<double, 3>& bary) const {
  constexpr int kMostSlivers = 16;
  for (int n = 0; n < kMostSlivers && sliver(s, t); ++n) {
    const Tri& k = s.topology->view.tri[size_t(t)];
    int entered = -1;
    for (int i = 0; i < 3; ++i)
      if (bary[size_t(i)] == 0) entered = i;
    if (entered < 0) return false;
    int best = -1;
    double best2 = 1e300, best_f = 0;
    for (int i = 0; i < 3; ++i) {
      if (i == entered) continue;
      const Vec3 a = at(s, k[size_t((i + 1) % 3)]), b = at(s, k[size_t((i + 2) % 3)]);
      const double ab2 = (b - a).squaredNorm(), f = ab2 > 0 ? std::clamp((x - a).dot(b - a) / ab2, 0.0, 1.0) : 0;
      const double d2 = (a + f * (b - a) - x).squaredNorm();
      if (d2 < best2) best2 = d2, best = i, best_f = f;
    }
    const int32_t next = beyond(s, t, best);
    if (next < 0) return false;
    const int32_t a = k[size_t((best + 1) % 3)], b = k[size_t((best + 2) % 3)];
    const Tri& m = s.topology->view.tri[size_t(next)];
    bary = {0, 0, 0};
    bary[size_t(corner_of(m, a))] = 1 - best_f;
    bary[size_t(corner_of(m, b))] = best_f;
    t = next;
  }
  return !sliver(s, t);
}

/// Whether d leads onward within triangle t from the place with these coordinates; keeps the way that is longest.
bool SurfaceWalk::try_triangle(const Snapshot& s, const Vec3& x, int32_t t, const std::array<double, 3>& bary,
                               const Vec3& d, Way& best) const {
  int32_t u = t;
  std::array<double, 3> w = bary;
  if (sliver(s, u) && !cross_slivers(s, x, u, w)) return false;
  const Tri& k = s.topology->view.tri[size_t(u)];
  const Vec3 a = at(s, k[0]), b = at(s, k[1]), c = at(s, k[2]);
  const Vec3 n = area_vector2(a, b, c);
  const double n2 = n.squaredNorm();
  if (!(n2 > 0)) return false;
  const Vec3 g = d - n * (d.dot(n) / n2);
  Way way;
  way.triangle = u;
  way.bary = w;
  way.length = g.norm();
  // Change of the coordinates along g: of corner i, the component of g along its height, over the height.
  way.rate = {n.cross(c - b).dot(g) / n2, n.cross(a - c).dot(g) / n2, n.cross(b - a).dot(g) / n2};
  const double scale = std::max({std::abs(way.rate[0]), std::abs(way.rate[1]), std::abs(way.rate[2])});
  if (!(scale > 0)) return false;
  for (size_t i = 0; i < 3; ++i) {
    if (w[i] > 0) continue;
    if (way.rate[i] < -1e-9 * scale) return false;  // out of the triangle again
    if (way.rate[i] < 1e-9 * scale) way.rate[i] = 0;
  }
  if (way.length > best.length * (1 + 1e-12)) best = way;
  return true;
}

Vec3 SurfaceWalk::walk(const Snapshot& s, SurfacePlace& p, const Vec3& d_mm) const {
  const auto& tri = s.topology->view.tri;
  Vec3 d = d_mm;
  for (int crossing = 0; crossing < kMostCrossings; ++crossing) {
    if (d.squaredNorm() < 1e-24) return Vec3::Zero();
    const Tri& k = tri[size_t(p.triangle)];
    const Vec3 x = position(s, p);
    int zeros = 0, zero = -1, whole = -1;
    for (int i = 0; i < 3; ++i) {
      if (p.bary[size_t(i)] == 0)
        ++zeros, zero = i;
      else
        whole = i;
    }
    Way way;
    if (zeros == 2) {  // at a corner: every triangle around it
      const int32_t v = k[size_t(whole)];
      for (const int32_t t : of(s).around(v)) {
        std::array<double, 3> w{0, 0, 0};
        w[size_t(corner_of(tri[size_t(t)], v))] = 1;
        try_triangle(s, x, t, w, d, way);
      }
      if (way.triangle < 0) {  // along an edge
        double most = 0;
        for (const int32_t t : of(s).around(v)) {
          const Tri& m = tri[size_t(t)];
          const int at_v = corner_of(m, v);
          for (const int step : {1, 2}) {
            const auto other = size_t((at_v + step) % 3);
            const Vec3 e = at(s, m[other]) - x;
            const double length = e.norm();
            if (!(length > 0) || !(d.dot(e) / length > most * (1 + 1e-12))) continue;
            most = d.dot(e) / length;
            way.triangle = t;
            way.bary = {0, 0, 0}, way.rate = {0, 0, 0};
            way.bary[size_t(at_v)] = 1;
            way.rate[other] = most / length, way.rate[size_t(at_v)] = -most / length;
          }
        }
        if (most < 1e-9 * d.norm()) return Vec3::Zero();
      }
    } else if (zeros == 1) {  // on an edge: both sides
      const int32_t a = k[size_t((zero + 1) % 3)], b = k[size_t((zero + 2) % 3)];
      try_triangle(s, x, p.triangle, p.bary, d, way);
      if (const int32_t t = beyond(s, p.triangle, zero); t >= 0) {
        std::array<double, 3> w{0, 0, 0};
        w[size_t(corner_of(tri[size_t(t)], a))] = p.bary[size_t((zero + 1) % 3)];
        w[size_t(corner_of(tri[size_t(t)], b))] = p.bary[size_t((zero + 2) % 3)];
        try_triangle(s, x, t, w, d, way);
      }
      if (way.triangle < 0) {
        const Vec3 e = at(s, b) - at(s, a);
        const double e2 = e.squaredNorm(), along = e2 > 0 ? d.dot(e) / e2 : 0;
        if (std::abs(along) * std::sqrt(e2) < 1e-9 * d.norm()) return Vec3::Zero();
        way.triangle = p.triangle;
        way.bary = p.bary;
        way.rate = {0, 0, 0};
        way.rate[size_t((zero + 1) % 3)] = -along, way.rate[size_t((zero + 2) % 3)] = along;
      }
    } else {
      try_triangle(s, x, p.triangle, p.bary, d, way);
      if (way.triangle < 0) {
        if (!sliver(s, p.triangle)) return Vec3::Zero();  // d is along the normal
        // The skin has squeezed the triangle that the place lies in: go to its nearest edge.
        size_t least = 0;
        for (size_t i = 1; i < 3; ++i)
          if (p.bary[i] < p.bary[least]) least = i;
        const double rest = 1 - p.bary[least];
        p.bary[least] = 0;
        for (double& w : p.bary) w /= rest;
        continue;
      }
    }
    // As far as the first coordinate that becomes zero.
    double t = 1;
    int stop = -1;
    for (int i = 0; i < 3; ++i) {
      const double w = way.bary[size_t(i)], r = way.rate[size_t(i)];
      if (w > 0 && r < 0 && -w / r < t) t = -w / r, stop = i;
    }
    p.triangle = way.triangle;
    double sum = 0;
    for (size_t i = 0; i < 3; ++i) {
      double w = way.bary[i] + t * way.rate[i];
      if (int(i) == stop || w < kZero) w = 0;
      sum += p.bary[i] = w;
    }
    for (double& w : p.bary) w /= sum;
    if (stop < 0) return Vec3::Zero();
    d *= 1 - t;
  }
  return d;
}

SurfacePlace SurfaceWalk::nearest_at_rest(const Snapshot& s, const Vec3& X, const Vec3& x) const {
  const SurfaceView& view = s.topology->view;
  SurfacePlace best;
  double best2 = 1e300, best_x2 = 1e300;
  constexpr double kSame2 = 1e-12;  // a micrometre
  for (const int32_t t : of(s).triangle) {
    const Tri& k = view.tri[size_t(t)];
    const Vec3 &a = view.X_mm[size_t(k[0])], &b = view.X_mm[size_t(k[1])], &c = view.X_mm[size_t(k[2])];
    const Vec3 out = (a.cwiseMin(b).cwiseMin(c) - X).cwiseMax(X - a.cwiseMax(b).cwiseMax(c)).cwiseMax(0.0);
    if (out.squaredNorm() > best2 + kSame2) continue;
    const TrianglePoint q = closest_on_triangle(X, a, b, c);
    const double d2 = (q.point - X).squaredNorm();
    if (d2 > best2 + kSame2) continue;
    const SurfacePlace p{t, q.bary};
    const double x2 = (position(s, p) - x).squaredNorm();
    if (d2 < best2 - kSame2 || x2 < best_x2) best2 = std::min(best2, d2), best_x2 = x2, best = p;
  }
  return best;
}

SurfacePlace SurfaceWalk::nearest(const Snapshot& s, const Vec3& x) const {
  SurfacePlace best;
  double best2 = 1e300;
  for (const int32_t t : of(s).triangle) {
    const Tri& k = s.topology->view.tri[size_t(t)];
    const Vec3 a = at(s, k[0]), b = at(s, k[1]), c = at(s, k[2]);
    const Vec3 out = (a.cwiseMin(b).cwiseMin(c) - x).cwiseMax(x - a.cwiseMax(b).cwiseMax(c)).cwiseMax(0.0);
    if (out.squaredNorm() >= best2) continue;
    const TrianglePoint q = closest_on_triangle(x, a, b, c);
    const double d2 = (q.point - x).squaredNorm();
    if (d2 < best2) best2 = d2, best = {t, q.bary};
  }
  return best;
}

Vec3 SurfaceWalk::position(const Snapshot& s, const SurfacePlace& p) const {
  const Tri& k = s.topology->view.tri[size_t(p.triangle)];
  return p.bary[0] * at(s, k[0]) + p.bary[1] * at(s, k[1]) + p.bary[2] * at(s, k[2]);
}

Vec3 SurfaceWalk::rest_position(const Snapshot& s, const SurfacePlace& p) const {
  const SurfaceView& view = s.topology->view;
  const Tri& k = view.tri[size_t(p.triangle)];
  return p.bary[0] * view.X_mm[size_t(k[0])] + p.bary[1] * view.X_mm[size_t(k[1])] +
         p.bary[2] * view.X_mm[size_t(k[2])];
}

Vec3 SurfaceWalk::normal(const Snapshot& s, const SurfacePlace& p) const {
  const Tri& k = s.topology->view.tri[size_t(p.triangle)];
  const Vec3 n = area_vector2(at(s, k[0]), at(s, k[1]), at(s, k[2]));
  const double length = n.norm();
  return length > 0 ? Vec3(n / length) : Vec3::UnitZ();
}

}  // namespace limberg
