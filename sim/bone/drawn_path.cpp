#include "sim/bone/drawn_path.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "sim/bone/osteotomy.h"

namespace limberg::bone {
namespace {

constexpr size_t kMostPlaces = 5000;
constexpr double kFarthest_mm = 10;   // a place may lie so far from the bone
constexpr double kTightest_mm = 0.4;  // places nearer together are one
constexpr double kSteep_mm = 2;       // a step of the way between two picks is not longer

std::string mm(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", v);
  return text;
}

struct OnBone {
  Vec3 x, normal;
};

/// From a to b along the surface in the plane of both and the mean normal: lines along the normal from the chord, each
/// crossing the one nearest to the place before. a is not repeated, b is.
bool straight_on(const BoneSurface& bone, const OnBone& a, const OnBone& b, std::vector<OnBone>& way) {
  const Vec3 sum = a.normal + b.normal, chord = b.x - a.x;
  if (sum.norm() < 0.5) return false;
  const Vec3 up = sum.normalized();
  if (std::abs(up.dot(chord)) > 0.95 * chord.norm()) return false;
  const size_t before = way.size();
  Vec3 last = a.x;
  double s = 0;
  const double step = std::min(0.5, DrawnPath::kSpacing_mm / chord.norm());
  while (s < 1) {
    // Shorter steps of the chord where the surface is steep.
    bool found = false;
    for (double d = step; d > step / 64; d /= 2) {
      const double t = std::min(1., s + d);
      const Vec3 foot = a.x + t * chord;
      double near = std::numeric_limits<double>::infinity();
      OnBone at;
      for (const Bvh::LineHit& h : bone.bvh.line(foot, up, -chord.norm() - 20, chord.norm() + 20)) {
        const Vec3 x = foot + h.t * up;
        if (const double far = (x - last).norm(); !h.from_outside == (up.dot(bone.normal(h.triangle)) >= 0) && far < near)
          near = far, at = {x, bone.normal(h.triangle)};
      }
      if (near > kSteep_mm) continue;
      way.push_back(at), last = at.x, s = t, found = true;
      break;
    }
    if (!found || way.size() > kMostPlaces) {
      way.resize(before);
      return false;
    }
  }
  if ((last - b.x).norm() > kSteep_mm) {
    way.resize(before);
    return false;
  }
  way.back() = b;
  return true;
}

bool crosses_itself(const std::vector<OnBone>& p) {
  const size_t n = p.size();
  for (size_t i = 0; i < n; ++i) {
    const Vec3 &a = p[i].x, &b = p[(i + 1) % n].x;
    const Vec3 up = p[i].normal, e = (b - a), f = up.cross(e);
    const double reach = 2 * e.norm() + 4;
    for (size_t j = i + 2; j < n; ++j) {
      if ((j + 1) % n == i) continue;
      const Vec3 c = p[j].x - a;
      if (c.squaredNorm() > reach * reach || p[j].normal.dot(up) < 0) continue;
      const Vec3 d = p[(j + 1) % n].x - a;
      if (std::abs(up.dot(c)) > 2 || std::abs(up.dot(d)) > 2) continue;
      const double l = e.squaredNorm(), cx = e.dot(c) / l, cy = f.dot(c), dx = e.dot(d) / l, dy = f.dot(d);
      if ((cy >= 0) == (dy >= 0)) continue;
      if (const double x = cx + (dx - cx) * cy / (cy - dy); x >= 0 && x < 1) return true;
    }
  }
  return false;
}

}  // namespace

DrawnPath lay_path(const BoneSurface& bone, const std::vector<Vec3>& path) {
  DrawnPath out;
  const auto refuse = [&](std::string why) {
    out = {};
    out.reason = std::move(why);
    return out;
  };
  if (path.size() < 3) return refuse("a contour has at least three places");
  if (path.size() > kMostPlaces) return refuse("a contour has at most " + std::to_string(kMostPlaces) + " places");
  std::vector<OnBone> at;
  for (const Vec3& p : path) {
    if (!p.allFinite()) return refuse("a place of the contour is not finite");
    const Bvh::Closest c = bone.bvh.closest(p);
    if (c.distance_mm > kFarthest_mm) return refuse("a place of the contour lies " + mm(c.distance_mm) + " from the bone; at most " + mm(kFarthest_mm) + " was expected");
    at.push_back({c.point_mm, bone.normal(c.triangle)});
  }
  // Drawn or picked: a drawn path has many places and mostly small steps.
  std::vector<double> step;
  for (size_t i = 0; i + 1 < at.size(); ++i) step.push_back((at[i + 1].x - at[i].x).norm());
  std::vector<double> sorted = step;
  std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
  const double usual = sorted[sorted.size() / 2], longest = *std::max_element(step.begin(), step.end());
  const double gap = (at.back().x - at.front().x).norm();
  if (at.size() >= 12 && usual < kPickStep_mm && gap > std::max(kPickStep_mm, 2 * longest))
    return refuse("the contour is open: its ends lie " + mm(gap) + " apart");
  std::vector<OnBone> way;
  for (size_t i = 0; i < at.size(); ++i) {
    const OnBone& b = at[(i + 1) % at.size()];
    const double d = (b.x - at[i].x).norm();
    if (d < 1e-9) continue;
    if (d <= 1.5 * DrawnPath::kSpacing_mm) way.push_back(b);
    else if (!straight_on(bone, at[i], b, way)) return refuse("the bone turns too much between two places of the contour, " + mm(d) + " apart; a place between them was expected");
  }
  // Closed, from the first place on; no two places nearer than the tightest spacing.
  std::vector<OnBone> kept;
  for (const OnBone& p : way)
    if (kept.empty() || (p.x - kept.back().x).norm() >= kTightest_mm) kept.push_back(p);
  while (kept.size() > 1 && (kept.front().x - kept.back().x).norm() < kTightest_mm) kept.pop_back();
  if (kept.size() < 6) return refuse("the contour is too small: it encloses nothing");
  if (crosses_itself(kept)) return refuse("the contour crosses itself");
  const size_t n = kept.size();
  std::vector<Vec3> normal(n), next(n);
  for (size_t i = 0; i < n; ++i) out.x_mm.push_back(kept[i].x), normal[i] = kept[i].normal;
  // Faces are a few mm wide: the blade's direction is the mean over about that length.
  for (int pass = 0; pass < 6; ++pass) {
    for (size_t i = 0; i < n; ++i) {
      const Vec3 s = normal[(i + n - 1) % n] + normal[i] + normal[(i + 1) % n];
      next[i] = s.norm() > 0.1 ? s.normalized() : normal[i];
    }
    std::swap(normal, next);
  }
  for (size_t i = 0; i < n; ++i) {
    out.inward.push_back(-normal[i]);
    double depth = std::numeric_limits<double>::infinity();
    for (const Bvh::LineHit& h : bone.bvh.line(out.x_mm[i], -normal[i], 0.05, 1e3))
      if (!h.from_outside) {
        depth = h.t;
        break;
      }
    out.depth_mm.push_back(depth);
  }
  return out;
}

bool is_solid(const DrawnPath& p, double deepest) {
  size_t solid = 0;
  const size_t n = p.x_mm.size();
  for (size_t i = 0; i < n; ++i) {
    if (!(p.depth_mm[i] <= deepest)) {
      ++solid;
      continue;
    }
    const Vec3 out = p.x_mm[i] + p.depth_mm[i] * p.inward[i];
    double near = std::numeric_limits<double>::infinity();
    for (const Vec3& x : p.x_mm) near = std::min(near, (x - out).norm());
    if (near < 0.5 * p.depth_mm[i]) ++solid;
  }
  return 2 * solid > n;
}

Ribbon sweep(const DrawnPath& p, double above, const std::vector<double>& depth) {
  Ribbon r;
  const size_t n = p.x_mm.size();
  for (size_t i = 0; i < n; ++i) r.X_mm.push_back(p.x_mm[i] - above * p.inward[i]);
  for (size_t i = 0; i < n; ++i) r.X_mm.push_back(p.x_mm[i] + depth[i] * p.inward[i]);
  for (size_t i = 0; i < n; ++i) {
    const int32_t a = int32_t(i), b = int32_t((i + 1) % n), c = a + int32_t(n), d = b + int32_t(n);
    r.tri.push_back({a, b, c}), r.tri.push_back({b, d, c});
  }
  return r;
}

}  // namespace limberg::bone
