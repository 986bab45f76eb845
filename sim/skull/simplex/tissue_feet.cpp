#include "sim/skull/simplex/tissue_feet.h"

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"

namespace limberg::simplex {

namespace {

constexpr double kDetour = 1.6,
                 // a normal that misses what is near is not followed (through the mouth to the palate)
    kDetour_mm = 5;
constexpr int kNormalRounds = 8;  // of evening out: over about as many edges
constexpr int kSweeps = 40;       // no case seen needs more than 20 (2026-11-27)
constexpr double kShares[] = {1, 0.8, 0.6, 0.45, 0.3, 0.2, 0.12};
constexpr double kBetter = 1e-9;

/// 15552 V^2 / (sum l^2)^3: the third power of the mean ratio, with the sign of the volume.
double cubed_ratio(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double v = (b - a).cross(c - a).dot(d - a) / 6, l2 = (a - b).squaredNorm() + (a - c).squaredNorm() +
                                                             (a - d).squaredNorm() + (b - c).squaredNorm() +
                                                             (b - d).squaredNorm() + (c - d).squaredNorm();
  return l2 > 0 ? 15552 * v * std::abs(v) / (l2 * l2 * l2) : 0;
}

struct Feet {
  const TissuePatch& p;
  const Bvh& bone;
  double farthest;
  int layers;
  const TissueFloor& floor;
  std::vector<std::vector<int32_t>> prisms{};  // of a node
  std::vector<Vec3> even{};                    // normals, evened out
  std::vector<uint8_t> lost{};                 // nodes with no bone under them
  TissueFeet out{};

  /// The worst mean ratio in a prism, below 0 where it folds. All diagonals of its sides are asked, for a prism that is
  /// sound one way only folds when it is pressed. A column that is too short counts for as much less.
  double worst(int32_t t) const {
    const Tri& v = p.tri[size_t(t)];
    std::array<Vec3, 3> low, high;
    double length2 = 1e300;
    for (size_t k = 0; k < 3; ++k) {
      low[k] = out.bottom[size_t(v[k])], high[k] = p.top[size_t(v[k])];
      length2 = std::min(length2, (high[k] - low[k]).squaredNorm());
    }
    double q = 1;
    for (size_t k = 0; k < 3; ++k)
      q = std::min({q, cubed_ratio(low[0], low[1], low[2], high[k]), cubed_ratio(high[0], high[2], high[1], low[k])});
    const double least2 = floor.thickness_mm * floor.thickness_mm;
    if (q > 0 && length2 < least2) return floor.shape * (std::sqrt(length2 / least2) - 1);
    if (q <= 0) return elementary::cbrt(q);
    q = 1;
    Tri order = v;
    std::sort(order.begin(), order.end());
    std::array<size_t, 3> at{};
    for (size_t k = 0; k < 3; ++k) at[k] = size_t(std::find(v.begin(), v.end(), order[k]) - v.begin());
    for (int l = 0; l < layers; ++l) {
      std::array<Vec3, 6> x;
      for (size_t k = 0; k < 3; ++k) {
        const Vec3 &a = low[at[k]], &b = high[at[k]];
        x[k] = a + double(l) / layers * (b - a), x[k + 3] = a + double(l + 1) / layers * (b - a);
      }
      for (const auto& n : prism_tets({0, 1, 2}))
        q = std::min(q, std::abs(cubed_ratio(x[size_t(n[0])], x[size_t(n[1])], x[size_t(n[2])], x[size_t(n[3])])));
    }
    return elementary::cbrt(q);
  }
  bool sound(double ratio) const { return ratio >= floor.shape; }
  /// What its prisms lack to be sound; 0: nothing. No move of a foot makes the sum over the patch larger.
  double lacks(size_t node) const {
    double sum = 0;
    for (const int32_t t : prisms[node])
      if (const double q = worst(t); !sound(q)) sum += floor.shape - q;
    return sum;
  }

  TissueFeet run() {
    const size_t n = p.top.size();
    prisms.resize(n);
    for (size_t t = 0; t < p.tri.size(); ++t)
      for (const int32_t v : p.tri[t]) prisms[size_t(v)].push_back(int32_t(t));
    even_normals();
    out.bottom.resize(n), out.hovers.assign(n, 0), lost.assign(n, 0);
    for (size_t i = 0; i < n; ++i) {
      Vec3 d;
      lost[i] = !way_to_bone(bone, p.top[i], p.normal[i], farthest, d);
      // Bone outside of the skin, as where it was cut or pierces it: the way leads outwards.
      out.bottom[i] = lost[i] ? p.top[i] : Vec3(p.top[i] + d);
    }
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool moved = false;
      for (size_t i = 0; i < n; ++i)
        if (!lost[i]) moved |= better(i);
      if (!moved) break;
    }
    name_unsound();
    return std::move(out);
  }

  /// Of unsound prisms that share a node the worst: the others may stand without it.
  void name_unsound() {
    constexpr double kSound = 2;
    std::vector<double> q(p.tri.size(), kSound);
    for (size_t t = 0; t < q.size(); ++t) {
      bool gone = false;
      for (const int32_t v : p.tri[t]) gone |= lost[size_t(v)] != 0;
      if (const double w = gone ? -2 : worst(int32_t(t)); !sound(w)) q[t] = w;
    }
    for (size_t t = 0; t < q.size(); ++t) {
      bool worst_here = q[t] < kSound;
      for (const int32_t v : p.tri[t])
        for (const int32_t u : prisms[size_t(v)])
          if (q[size_t(u)] < q[t]) worst_here = false;
      if (worst_here) out.unsound.push_back(int32_t(t));
    }
  }

  void even_normals() {
    even = p.normal;
    for (int round = 0; round < kNormalRounds; ++round) {
      std::vector<Vec3> next = even;
      for (size_t i = 0; i < even.size(); ++i) {
        for (const int32_t j : p.near[i]) next[i] += even[size_t(j)];
        if (const double l = next[i].norm(); l > 0) next[i] /= l;
      }
      even = std::move(next);
    }
  }

  /// Moves the foot of a node to a better place, if one of its prisms is below the floor and there is one.
  bool better(size_t i) {
    const double before = lacks(i);
    if (before <= 0) return false;
    const Vec3 top = p.top[i], here = out.bottom[i];
    Vec3 mean = Vec3::Zero(), best = here;
    for (const int32_t j : p.near[i]) mean += (out.bottom[size_t(j)] - p.top[size_t(j)]) / double(p.near[i].size());
    double least = before;
    uint8_t best_hovers = out.hovers[i];
    const auto ask = [&](const Vec3& at, uint8_t hovers) {
      if (least <= 0) return;  // sound is enough: what is asked first changes least
      out.bottom[i] = at;
      if (const double q = lacks(i); q < least - kBetter) least = q, best = at, best_hovers = hovers;
    };
    for (const double mix : {0.25, 0.5, 1.}) ask(bone.closest(top + (1 - mix) * (here - top) + mix * mean).point_mm, 0);
    for (const Vec3& way : {Vec3(here - top), mean, Vec3(-even[i])}) {
      if (!(way.norm() > 0)) continue;
      const Vec3 u = way.normalized();
      const double nearest = (bone.closest(top).point_mm - top).norm();
      Bvh::LineHit hit;
      const bool met = bone.line(top, u, 1e-9, farthest, std::span(&hit, 1)) > 0;
      const double length = met ? hit.t : std::max(nearest, std::min(way.norm(), farthest));
      for (const double share : kShares)
        if (share * length >= floor.thickness_mm) ask(top + share * length * u, share < 1 || !met);
    }
    out.bottom[i] = best, out.hovers[i] = best_hovers;
    return best != here;
  }
};

}  // namespace

double mean_ratio(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return elementary::cbrt(cubed_ratio(a, b, c, d));
}

std::array<std::array<int32_t, 4>, 3> prism_tets(const Tri& t) {
  Tri v = t;
  std::sort(v.begin(), v.end());
  return {{{v[0], v[1], v[2], v[2] + 3}, {v[0], v[1], v[1] + 3, v[2] + 3}, {v[0], v[0] + 3, v[1] + 3, v[2] + 3}}};
}

bool way_to_bone(const Bvh& bone, const Vec3& top, const Vec3& normal, double farthest, Vec3& way) {
  const Bvh::Closest c = bone.closest(top, farthest);
  if (c.triangle < 0) return false;
  way = c.point_mm - top;
  Bvh::LineHit hit;
  if (bone.line(top, -normal, 1e-9, kDetour * c.distance_mm + kDetour_mm, std::span(&hit, 1)) > 0)
    way = -hit.t * normal;
  return true;
}

TissueFeet sound_feet(const TissuePatch& p, const Bvh& bone, double farthest, int layers, const TissueFloor& floor) {
  return Feet{p, bone, farthest, layers, floor}.run();
}

}  // namespace limberg::simplex
