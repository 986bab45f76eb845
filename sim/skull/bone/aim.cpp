#include "sim/skull/bone/aim.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include "sim/base/elementary.h"

namespace limberg::bone {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kTurn = 6;   // mm: of area for each mm of depth and radian^2
constexpr double kBack = 20;  // mm
constexpr int kSmoothings = 8;

/// Way over the surface from the path to every vertex, along edges.
std::vector<double> ways_from(const simplex::Mesh& m, const BoneSurface& bone, const DrawnPath& path) {
  std::vector<double> way(m.nbr.size(), kInf);
  using Entry = std::pair<double, int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (const Vec3& x : path.x_mm) {
    const int32_t t = bone.bvh.closest(x).triangle;
    for (int k : {1, 2}) {  // 0 is the centre of a face
      const int32_t v = bone.tri[size_t(t)][size_t(k)];
      if (const double d = (m.x_mm[size_t(v)] - x).norm(); d < way[size_t(v)]) way[size_t(v)] = d, open.push({d, v});
    }
  }
  while (!open.empty()) {
    const auto [d, v] = open.top();
    open.pop();
    if (d > way[size_t(v)]) continue;
    for (int32_t w : m.nbr[size_t(v)])
      if (const double far = d + (m.x_mm[size_t(w)] - m.x_mm[size_t(v)]).norm(); far < way[size_t(w)])
        way[size_t(w)] = far, open.push({far, w});
  }
  return way;
}

/// Evenly over the cap about z (Fibonacci's spiral), the first one along it.
std::vector<Vec3> cap() {
  std::vector<Vec3> out;
  const double low = elementary::cos(kCone_deg * std::numbers::pi / 180),
               golden = std::numbers::pi * (3 - std::sqrt(5.));
  for (int k = 0; k < kDirections; ++k) {
    const double z = 1 - (1 - low) * k / (kDirections - 1), r = std::sqrt(std::max(0., 1 - z * z));
    out.emplace_back(r * elementary::cos(golden * k), r * elementary::sin(golden * k), z);
  }
  return out;
}

struct Ray {
  Vec3 u, exit;
  double depth;
};

class Aimer {
 public:
  Aimer(const simplex::Mesh& m, const BoneSurface& bone, const DrawnPath& path, double longest)
      : bone_(bone), path_(path), longest_(longest), way_(ways_from(m, bone, path)) {}

  /// The first place where a ray leaves the bone, when that is on the other table.
  bool look(size_t i, const Vec3& u, Ray& out) const {
    for (const Bvh::LineHit& h : bone_.bvh.line(path_.x_mm[i], u, 0.05, longest_)) {
      if (h.from_outside) return false;  // was outside: along a surface that is hollow
      const Tri& t = bone_.tri[size_t(h.triangle)];
      out = {u, path_.x_mm[i] + h.t * u, h.t};
      return std::min(way_[size_t(t[1])], way_[size_t(t[2])]) > kAround * h.t;
    }
    return false;
  }

 private:
  const BoneSurface& bone_;
  const DrawnPath& path_;
  double longest_;
  std::vector<double> way_;
};

double cost(const Vec3& x, const Vec3& y, const Ray& p, const Ray& q) {
  const Vec3 along = y - x, out = q.exit - p.exit;
  const double mean = 0.5 * (p.depth + q.depth), step = along.norm();
  const double back = step > 0 ? std::max(0., -out.dot(along) / step) : 0;
  return 0.5 * (step + out.norm()) * mean + kTurn * 0.5 * mean * (q.u - p.u).squaredNorm() + kBack * back;
}

}  // namespace

Aim aim_blade(const simplex::Mesh& m, const BoneSurface& bone, const DrawnPath& path, double deepest) {
  Aim out;
  const Aimer aimer(m, bone, path, kLonger * deepest);
  const std::vector<Vec3> cone = cap();
  // The places from which the other table is seen, with all the ways to it.
  std::vector<size_t> place;
  std::vector<std::vector<Ray>> rays;
  size_t near = 0;
  for (size_t i = 0; i < path.x_mm.size(); ++i) {
    const Vec3 n = path.inward[i], a = n.unitOrthogonal(), b = n.cross(a);
    std::vector<Ray> seen;
    Ray r;
    double least = kInf;
    for (const Vec3& c : cone)
      if (aimer.look(i, c.x() * a + c.y() * b + c.z() * n, r)) seen.push_back(r), least = std::min(least, r.depth);
    near += least <= deepest;
    if (!seen.empty()) place.push_back(i), rays.push_back(std::move(seen));
  }
  const size_t n = place.size();
  if (2 * near < path.x_mm.size() || n < 6) {
    out.reason = "from too many places of the contour no saw reaches the other table";
    return out;
  }
  // Around the path twice: the way that the second round takes does not depend on where the first began.
  std::vector<std::vector<int32_t>> from(2 * n);
  std::vector<double> best(rays[0].size(), 0);
  for (size_t k = 1; k <= 2 * n - 1; ++k) {
    const std::vector<Ray>&before = rays[(k - 1) % n], &here = rays[k % n];
    const Vec3 &x = path.x_mm[place[(k - 1) % n]], &y = path.x_mm[place[k % n]];
    std::vector<double> next(here.size(), kInf);
    from[k].assign(here.size(), -1);
    for (size_t j = 0; j < here.size(); ++j)
      for (size_t i = 0; i < before.size(); ++i)
        if (const double c = best[i] + cost(x, y, before[i], here[j]); c < next[j])
          next[j] = c, from[k][j] = int32_t(i);
    best = std::move(next);
  }
  std::vector<Ray> chosen(n);
  int32_t j = int32_t(std::min_element(best.begin(), best.end()) - best.begin());
  std::vector<int32_t> way(2 * n);
  for (size_t k = 2 * n; k-- > 0;) {
    way[k] = j;
    if (k > 0) j = from[k][size_t(j)];
  }
  // The middle of the two rounds: n / 2 .. n / 2 + n.
  for (size_t k = n / 2; k < n / 2 + n; ++k) chosen[k % n] = rays[k % n][size_t(way[k])];
  for (int pass = 0; pass < kSmoothings; ++pass) {
    std::vector<Ray> next = chosen;
    for (size_t k = 0; k < n; ++k) {
      const Vec3 u = (chosen[(k + n - 1) % n].u + 2 * chosen[k].u + chosen[(k + 1) % n].u).normalized();
      if (Ray r; aimer.look(place[k], u, r)) next[k] = r;
    }
    chosen = std::move(next);
  }
  // Places from which nothing is seen take what their neighbours have.
  out.inward.resize(path.x_mm.size()), out.depth_mm.resize(path.x_mm.size());
  for (size_t k = 0; k < n; ++k) {
    const size_t a = place[k], gap = (place[(k + 1) % n] + path.x_mm.size() - a) % path.x_mm.size();
    for (size_t s = 0; s < std::max<size_t>(gap, 1); ++s) {
      const size_t i = (a + s) % path.x_mm.size();
      const double w = double(s) / double(std::max<size_t>(gap, 1));
      const Vec3 e = (1 - w) * chosen[k].exit + w * chosen[(k + 1) % n].exit - path.x_mm[i];
      if (s == 0)
        out.inward[i] = chosen[k].u, out.depth_mm[i] = chosen[k].depth;
      else
        out.inward[i] = e.normalized(), out.depth_mm[i] = e.norm();
    }
  }
  return out;
}

}  // namespace limberg::bone
