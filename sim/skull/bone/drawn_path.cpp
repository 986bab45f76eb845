#include "sim/skull/bone/drawn_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <queue>

#include "sim/geometry/polyline.h"
#include "sim/skull/bone/osteotomy.h"

namespace limberg::bone {
namespace {

constexpr size_t kMostPlaces = 5000;
constexpr double kFarthest_mm = 10;   // a place may lie so far from the bone
constexpr double kTightest_mm = 0.4;  // places nearer together are one
constexpr double kSteep_mm = 2;       // a step of the way between two picks is not longer

std::string mm(double v) { return fmt::format("{:.1f} mm", v); }

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
        if (const double far = (x - last).norm();
            !h.from_outside == (up.dot(bone.normal(h.triangle)) >= 0) && far < near)
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

/// Shortest ways over the surface, for two places between which it
/// turns too much to go straight on (over the rim of an orbit).
class Over {
 public:
  explicit Over(const BoneSurface& bone) : bone_(bone) {
    first_.assign(bone.X_mm.size() + 1, 0);
    for (const Tri& t : bone.tri)
      for (int32_t v : t) first_[size_t(v) + 1] += 2;
    for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    std::vector<int32_t> at(first_.begin(), first_.end() - 1);
    next_.resize(size_t(first_.back()));
    for (const Tri& t : bone.tri)
      for (size_t k = 0; k < 3; ++k)
        for (size_t l : {(k + 1) % 3, (k + 2) % 3}) next_[size_t(at[size_t(t[k])]++)] = t[l];
  }
  /// As straight_on. Refused when the way is longer than kDetour times the distance and kSteep_mm.
  bool way(const OnBone& a, const OnBone& b, std::vector<OnBone>& out) const {
    const double most = kDetour * (b.x - a.x).norm() + kSteep_mm;
    std::map<int32_t, std::pair<double, int32_t>> best;  // only what lies near
    using Entry = std::pair<double, int32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    for (int32_t v : bone_.tri[size_t(bone_.bvh.closest(a.x).triangle)]) {
      const double d = (X(v) - a.x).norm();
      best[v] = {d, -1}, open.push({d, v});
    }
    const Tri goal = bone_.tri[size_t(bone_.bvh.closest(b.x).triangle)];
    int32_t end = -1;
    double whole = most;
    while (!open.empty()) {
      const auto [d, v] = open.top();
      open.pop();
      if (d >= whole) break;
      if (d > best[v].first) continue;
      if (std::find(goal.begin(), goal.end(), v) != goal.end() && d + (b.x - X(v)).norm() < whole)
        end = v, whole = d + (b.x - X(v)).norm();
      for (int32_t i = first_[size_t(v)]; i < first_[size_t(v) + 1]; ++i) {
        const int32_t w = next_[size_t(i)];
        const double far = d + (X(w) - X(v)).norm();
        const auto known = best.find(w);
        if (far < most && (known == best.end() || far < known->second.first)) best[w] = {far, v}, open.push({far, w});
      }
    }
    if (end < 0) return false;
    std::vector<Vec3> x{b.x};
    for (int32_t v = end; v >= 0; v = best[v].second) x.push_back(X(v));
    x.push_back(a.x);
    std::reverse(x.begin(), x.end());
    // Even steps, then pulled taut on the surface.
    std::vector<Vec3> even;
    const double length = path_length(x);
    const int n = std::max(2, int(std::ceil(length / DrawnPath::kSpacing_mm)));
    double s = 0;
    for (size_t i = 0, k = 0; i + 1 < x.size(); ++i) {
      const double l = (x[i + 1] - x[i]).norm();
      for (; k <= size_t(n) && double(k) * length / n <= s + l; ++k)
        even.push_back(l > 0 ? Vec3(x[i] + (double(k) * length / n - s) / l * (x[i + 1] - x[i])) : x[i]);
      s += l;
    }
    if (even.size() < size_t(n) + 1) even.push_back(b.x);
    even.back() = b.x;
    for (int pass = 0; pass < 30; ++pass)
      for (size_t i = 1; i + 1 < even.size(); ++i)
        even[i] = bone_.bvh.closest(0.5 * (even[i - 1] + even[i + 1])).point_mm;
    for (size_t i = 1; i + 1 < even.size(); ++i)
      out.push_back({even[i], bone_.normal(bone_.bvh.closest(even[i]).triangle)});
    out.push_back(b);
    return true;
  }

 private:
  static constexpr double kDetour = 3;
  const Vec3& X(int32_t v) const { return bone_.X_mm[size_t(v)]; }
  const BoneSurface& bone_;
  std::vector<int32_t> first_, next_;
};

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
    if (c.distance_mm > kFarthest_mm)
      return refuse("place " + std::to_string(at.size() + 1) + " of the contour lies " + mm(c.distance_mm) +
                    " from the bone; at most " + mm(kFarthest_mm) + " was expected");
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
  std::optional<Over> over;
  for (size_t i = 0; i < at.size(); ++i) {
    const OnBone& b = at[(i + 1) % at.size()];
    const double d = (b.x - at[i].x).norm();
    if (d < 1e-9) continue;
    if (d <= 1.5 * DrawnPath::kSpacing_mm) {
      way.push_back(b);
      continue;
    }
    if (straight_on(bone, at[i], b, way)) continue;
    if (!over) over.emplace(bone);
    if (!over->way(at[i], b, way))
      return refuse("the bone turns too much between two places of the contour, " + mm(d) +
                    " apart; a place between them was expected");
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

namespace {

/// Rows of places around the path, the first over the surface.
Ribbon between_rows(const std::vector<std::vector<Vec3>>& row) {
  Ribbon r;
  const int32_t n = int32_t(row[0].size());
  for (const std::vector<Vec3>& x : row) r.X_mm.insert(r.X_mm.end(), x.begin(), x.end());
  for (int32_t k = 0; k + 1 < int32_t(row.size()); ++k)
    for (int32_t i = 0; i < n; ++i) {
      const int32_t a = k * n + i, b = k * n + (i + 1) % n, c = a + n, d = b + n;
      r.tri.push_back({a, b, c}), r.tri.push_back({b, d, c});
    }
  return r;
}

std::vector<Vec3> along(const DrawnPath& p, const std::vector<Vec3>& u, const std::vector<double>& by) {
  std::vector<Vec3> out;
  for (size_t i = 0; i < p.x_mm.size(); ++i) out.push_back(p.x_mm[i] + by[i] * u[i]);
  return out;
}

}  // namespace

Ribbon sweep(const DrawnPath& p, double above, const std::vector<double>& depth) {
  return between_rows({along(p, p.inward, std::vector<double>(depth.size(), -above)), along(p, p.inward, depth)});
}

Ribbon sweep_tilted(const DrawnPath& p, const std::vector<Vec3>& inward, double above,
                    const std::vector<double>& depth) {
  return between_rows({along(p, p.inward, std::vector<double>(depth.size(), -above)), p.x_mm, along(p, inward, depth)});
}

}  // namespace limberg::bone
