#include "devices/stroke_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "devices/drawn_curve.h"
#include "sim/base/elementary.h"
#include "sim/geometry/overrun.h"
#include "sim/geometry/polyline.h"

namespace limberg {

namespace {

struct Line {
  Vec2 at{0, 0}, along{1, 0};
  Vec2 foot(const Vec2& p) const { return at + along.dot(p - at) * along; }
};

/// Total least squares through p[a..b], the ends' tenth left out where the hand turns and waits.
Line fit(const std::vector<Vec2>& p, size_t a, size_t b) {
  const Vec2 chord = p[b] - p[a];
  const double l2 = chord.squaredNorm();
  Vec2 mean = Vec2::Zero();
  std::vector<Vec2> inner;
  for (size_t i = a; i <= b; ++i) {
    const double t = l2 > 0 ? (p[i] - p[a]).dot(chord) / l2 : 0.5;
    if (t >= 0.1 && t <= 0.9) inner.push_back(p[i]), mean += p[i];
  }
  if (inner.size() < 3) return {p[a], chord.normalized()};
  mean /= double(inner.size());
  double xx = 0, xy = 0, yy = 0;
  for (const Vec2& q : inner) {
    const Vec2 d = q - mean;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const double angle = 0.5 * elementary::atan2(2 * xy, xx - yy);  // major axis of the scatter
  Vec2 along(elementary::cos(angle), elementary::sin(angle));
  if (along.dot(chord) < 0) along = -along;
  return {mean, along};
}

/// Where two edges' lines meet, if the turn is a corner and the place is near the knot; else the knot's feet, averaged.
Vec2 corner(const Line& a, const Line& b, const Vec2& knot, const PathSettings& s) {
  const double turn =
      std::abs(elementary::atan2(cross2(a.along, b.along), a.along.dot(b.along))) * 180 / std::numbers::pi;
  if (turn >= s.corner_deg && turn <= 180 - s.corner_deg) {
    const double t = cross2(b.at - a.at, b.along) / cross2(a.along, b.along);
    const Vec2 meet = a.at + t * a.along;
    if ((meet - knot).norm() <= s.corner_move_mm) return meet;
  }
  const Vec2 feet = 0.5 * (a.foot(knot) + b.foot(knot));
  return (feet - knot).norm() <= s.tolerance_mm ? feet : knot;
}

/// The chord between two jittering points is a poor edge: knots without which the points still lie along the line
/// fitted through them go, the least needed first. Along: half the tolerance in the mean square, and no point off by
/// more than one and a half, so that a single jerk is not a corner.
void merge_edges(const std::vector<Vec2>& p, std::vector<size_t>& knot, double tolerance) {
  while (knot.size() > 2) {
    double least = tolerance;
    size_t drop = 0;
    for (size_t k = 1; k + 1 < knot.size(); ++k) {
      const size_t a = knot[k - 1], b = knot[k + 1];
      if ((p[a] - p[b]).norm() <= tolerance) continue;  // there and back again is not an edge
      const Line line = fit(p, a, b);
      const Vec2 jitter = 2 * tolerance * line.along;  // a waiting hand also trembles along the edge
      const Vec2 from = line.foot(p[a]) - jitter, to = line.foot(p[b]) + jitter;
      double worst = 0, sum2 = 0;
      for (size_t i = a; i <= b; ++i) {
        const double d = distance_to_segment(p[i], from, to);
        worst = std::max(worst, d);
        sum2 += d * d;
      }
      const double off = std::max(worst / 1.5, 2 * std::sqrt(sum2 / double(b - a + 1)));
      if (off <= least) least = off, drop = k;
    }
    if (drop == 0) return;
    knot.erase(knot.begin() + long(drop));
  }
}

/// Drops the ends of edges that are too short to be meant: of each such edge the knot that bends the path less goes.
void join_short(const std::vector<Vec2>& p, std::vector<size_t>& knot, double min_edge_mm) {
  bool again = true;
  while (again && knot.size() > 2) {
    again = false;
    size_t shortest = 0;
    double least = min_edge_mm;
    for (size_t i = 0; i + 1 < knot.size(); ++i)
      if (const double l = (p[knot[i + 1]] - p[knot[i]]).norm(); l < least) least = l, shortest = i, again = true;
    if (!again) break;
    size_t drop;
    if (shortest == 0) {
      drop = 1;
    } else if (shortest + 2 == knot.size()) {
      drop = shortest;
    } else {
      const double left = distance_to_segment(p[knot[shortest]], p[knot[shortest - 1]], p[knot[shortest + 1]]);
      const double right = distance_to_segment(p[knot[shortest + 1]], p[knot[shortest]], p[knot[shortest + 2]]);
      drop = left <= right ? shortest : shortest + 1;
    }
    knot.erase(knot.begin() + long(drop));
  }
}

/// The kept points of a path between its ends and `fixed`, a point to begin with (0: none).
std::vector<size_t> knots_of(const std::vector<Vec2>& p, size_t fixed, const PathSettings& s) {
  std::vector<uint8_t> keep(p.size(), 0);
  keep.front() = keep[fixed] = keep.back() = 1;
  if (fixed > 0) keep_corners(p, 0, fixed, s.tolerance_mm, keep);
  keep_corners(p, fixed, p.size() - 1, s.tolerance_mm, keep);
  std::vector<size_t> knot;
  for (size_t i = 0; i < p.size(); ++i)
    if (keep[i]) knot.push_back(i);
  join_short(p, knot, s.min_edge_mm);
  merge_edges(p, knot, s.tolerance_mm);
  return knot;
}

/// Points that stand in each other's place add nothing but jitter.
std::vector<Vec2> without_repeats(const std::vector<Vec2>& points) {
  std::vector<Vec2> p;
  for (const Vec2& q : points)
    if (q.allFinite() && (p.empty() || (q - p.back()).norm() > 1e-9)) p.push_back(q);
  return p;
}

/// What lies between two corners: an edge, or a curve that began as several.
struct Side {
  Line begin, end;         // its tangents there; an edge's are both its line
  std::vector<Vec2> bend;  // of a curve, without its ends
  size_t last;             // the knot where it ends
};

/// From knot k to knot `to`; nothing when the points there are too few for a curve.
std::optional<Side> curve(const Course& course, size_t k, size_t to, const PathSettings& s) {
  constexpr double kAtEnds_mm = 0.5;  // a corner is moved by about so much
  const DrawnCurve c = drawn_curve(course, k, to, s.tolerance_mm);
  if (c.at.size() < 3) return {};
  Side side{{c.at.front(), c.tangent_at_begin}, {c.at.back(), c.tangent_at_end}, {}, to};
  for (const Vec2& q : c.at)
    if ((q - c.at.front()).norm() > kAtEnds_mm && (q - c.at.back()).norm() > kAtEnds_mm) side.bend.push_back(q);
  return side;
}

std::vector<Side> sides_of(const std::vector<Vec2>& p, const std::vector<size_t>& knot, const PathSettings& s) {
  const Course course = s.curves ? course_of(p, knot) : Course{};
  std::vector<Side> sides;
  for (size_t k = 0; k + 1 < knot.size();) {
    size_t to = k + 1;
    std::optional<Side> curved;
    if (s.curves) {
      while (to + 1 < knot.size() && bends_at(course, to, s.tolerance_mm)) ++to;
      if (to > k + 1 || is_arc(course, k, s.tolerance_mm)) curved = curve(course, k, to, s);
    }
    if (curved) {
      sides.push_back(std::move(*curved));
    } else {
      for (size_t i = k; i < to; ++i) {
        const Line line = fit(p, knot[i], knot[i + 1]);
        sides.push_back({line, line, {}, i + 1});
      }
    }
    k = to;
  }
  return sides;
}

}  // namespace

std::vector<Vec2> simplify_path(const std::vector<Vec2>& points, const PathSettings& s) {
  const std::vector<Vec2> p = without_repeats(points);
  if (p.size() < 2) return p;
  const std::vector<size_t> knot = knots_of(p, 0, s);
  const std::vector<Side> sides = sides_of(p, knot, s);
  std::vector<Vec2> out{sides.front().begin.foot(p.front())};
  for (size_t i = 0; i < sides.size(); ++i) {
    out.insert(out.end(), sides[i].bend.begin(), sides[i].bend.end());
    if (i + 1 < sides.size()) out.push_back(corner(sides[i].end, sides[i + 1].begin, p[knot[sides[i].last]], s));
  }
  out.push_back(sides.back().end.foot(p.back()));
  return out;
}

std::vector<Vec2> simplify_outline(const std::vector<Vec2>& points, const PathSettings& s) {
  std::vector<Vec2> p = without_repeats(points);
  if (p.size() < 4) return p;

  p.resize(points_to_closing(p));
  if ((p.back() - p.front()).norm() < 3 * s.tolerance_mm && p.size() > 4) p.pop_back();

  // Begin at a point that is a corner whatever the start was: the one furthest from the middle.
  Vec2 middle = Vec2::Zero();
  for (const Vec2& q : p) middle += q / double(p.size());
  size_t far = 0;
  for (size_t i = 1; i < p.size(); ++i)
    if ((p[i] - middle).squaredNorm() > (p[far] - middle).squaredNorm()) far = i;
  std::rotate(p.begin(), p.begin() + long(far), p.end());
  p.push_back(p.front());

  // Douglas-Peucker needs two ends that differ: the start and the point furthest from it.
  size_t opposite = 0;
  for (size_t i = 0; i < p.size(); ++i)
    if ((p[i] - p[0]).squaredNorm() > (p[opposite] - p[0]).squaredNorm()) opposite = i;
  const std::vector<size_t> knot = knots_of(p, opposite, s);
  if (knot.size() < 4) {  // flat: no area to speak of
    p.pop_back();
    return p;
  }

  std::vector<Line> edge;
  for (size_t i = 0; i + 1 < knot.size(); ++i) edge.push_back(fit(p, knot[i], knot[i + 1]));
  std::vector<Vec2> out;
  for (size_t i = 0; i + 1 < knot.size(); ++i)
    out.push_back(corner(edge[i == 0 ? edge.size() - 1 : i - 1], edge[i], p[knot[i]], s));
  return out;
}

std::vector<Vec3> simplify_in_space(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, bool outline,
                                    const PathSettings& s) {
  if (points.size() < 2) return points;
  Vec3 n = Vec3::Zero();
  for (const Vec3& normal : normals) n += normal;
  if (!(n.norm() > 1e-6 * double(normals.size()))) n = Vec3::UnitZ();  // all round: any plane is as good
  n.normalize();
  const Vec3 e1 = n.unitOrthogonal(), e2 = n.cross(e1);
  std::vector<Vec2> flat;
  for (const Vec3& p : points) flat.emplace_back((p - points[0]).dot(e1), (p - points[0]).dot(e2));
  std::vector<Vec3> path;
  for (const Vec2& q : outline ? simplify_outline(flat, s) : simplify_path(flat, s)) {
    double best = 1e300, height = 0;
    for (size_t i = 0; i + 1 < flat.size(); ++i) {
      const Vec2 way = flat[i + 1] - flat[i];
      const double t = std::clamp((q - flat[i]).dot(way) / std::max(way.squaredNorm(), 1e-12), 0.0, 1.0);
      const double d2 = (flat[i] + t * way - q).squaredNorm();
      if (d2 < best) best = d2, height = ((1 - t) * (points[i] - points[0]) + t * (points[i + 1] - points[0])).dot(n);
    }
    path.push_back(points[0] + q.x() * e1 + q.y() * e2 + height * n);
  }
  return path;
}

}  // namespace limberg
