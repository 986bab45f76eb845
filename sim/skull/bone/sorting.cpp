#include "sim/skull/bone/sorting.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/geometry/rotation.h"
#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/ring_ways.h"
#include "sim/skull/bone/shape.h"
#include "sim/skull/bone/words.h"
#include "sim/skull/simplex/dual.h"

namespace limberg::bone {
namespace {

using Eigen::Isometry3d;

constexpr double kTogether_mm = 0.6;  // rings that are counted as running together, and 4 times their noise
constexpr double kTouch_mm = 0.3;     // cut surfaces touch that lie no further apart, and so many times the noise
constexpr double kExact_mm = 0.05;    // a fit looks at least so far
constexpr double kExplained = 1.5;  // a residual may be so much greater than what the noise of the rings explains, and
constexpr double kUnexplained_mm = 0.12;
constexpr size_t kTried = 24, kFitted = 8;   // ways that are fitted a little, and to the end
constexpr double kOne_mm = 3, kOne_deg = 4;  // with noise, fits that end so near to each other are one
constexpr double kSettle_mm = 3;             // places so far apart are one at first
constexpr int kRounds = 15;                  // in which a group of pieces settles

/// A run of edges of a ring, and the box around them: most are too far from a place to be looked at one by one.
struct Stretch {
  size_t begin = 0, end = 0;  // corners
  Vec3 lo_mm = Vec3::Constant(1e300), hi_mm = Vec3::Constant(-1e300);
};
constexpr size_t kStretch = 16;  // edges at most

struct SortedPiece {
  std::vector<Ring> rings;
  FragmentShape shape;
  std::vector<Vec3> corner, edge;  // of all rings: places, and edge vectors to the next
  std::vector<Vec3> tangent;
  std::vector<double> share_mm;  // of the ring's length that a corner stands for
  std::vector<Stretch> stretch;  // of all corners, in their order
  double noise_mm = 0;           // of all rings
  Vec3 middle() const { return 0.5 * (shape.lo_mm + shape.hi_mm); }
  Vec3 middle_at(const Isometry3d& T) const { return T * middle(); }
};

/// The small motion that brings the places nearest to the lines (least squares of the distances across them: a curve
/// may slide along itself, where nearest places would hold it back). Gauss-Newton; rotation about `about`.
Isometry3d towards_lines(const std::vector<Vec3>& from, const std::vector<Vec3>& to, const std::vector<Vec3>& along) {
  Vec3 about = Vec3::Zero();
  for (const Vec3& x : from) about += x / double(from.size());
  Eigen::Matrix<double, 6, 6> M = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
  for (size_t i = 0; i < from.size(); ++i) {
    const Mat3 P = Mat3::Identity() - along[i] * along[i].transpose();
    const Vec3 y = from[i] - about;
    Eigen::Matrix<double, 3, 6> J;
    J << 0, y.z(), -y.y(), 1, 0, 0, -y.z(), 0, y.x(), 0, 1, 0, y.y(), -y.x(), 0, 0, 0, 1;
    M += J.transpose() * P * J, g += J.transpose() * P * (to[i] - from[i]);
  }
  // What nothing holds stays where it is.
  for (int k : {0, 3}) {
    const double t = 1e-6 * M.block<3, 3>(k, k).trace();
    for (int i = k; i < k + 3; ++i) M(i, i) += t;
  }
  const Eigen::Matrix<double, 6, 1> d = M.ldlt().solve(g);
  const Vec3 w = d.head<3>();
  const double angle = std::min(w.norm(), 0.3);
  Isometry3d T = Isometry3d::Identity();
  if (angle > 0) T.linear() = rotation(angle, w.normalized());
  T.translation() = about + d.tail<3>() - T.linear() * about;
  return T;
}

/// What noise of both alone would leave as the distance of a
/// corner from a line, which is the mean of two corners or nearly.
double explained(const SortedPiece& a, const SortedPiece& b) {
  return std::sqrt(2.) * elementary::hypot(b.noise_mm, 0.82 * a.noise_mm);
}
double together_mm(const SortedPiece& a, const SortedPiece& b) { return kTogether_mm + 2.5 * explained(a, b); }

/// Corners of b on the rings of a, where they are nearer than that and run against each other.
struct Together {
  std::vector<Vec3> from, to, along;  // corners of b where they are now, the places on a's rings, a's tangents there
  std::vector<double> apart;
  double length = 0, residual = 1e9;
};
Together together(const SortedPiece& a, const SortedPiece& b, const Isometry3d& T, double near) {
  Together out;
  double sum = 0;
  for (size_t j = 0; j < b.corner.size(); ++j) {
    const Vec3 y = T * b.corner[j], t = T.linear() * b.tangent[j];
    if ((y.array() < a.shape.lo_mm.array() - near).any() || (y.array() > a.shape.hi_mm.array() + near).any()) continue;
    double best = near * near;
    Vec3 at, along;
    for (const Stretch& r : a.stretch) {
      if ((y - y.cwiseMax(r.lo_mm).cwiseMin(r.hi_mm)).squaredNorm() >= best) continue;
      for (size_t i = r.begin; i < r.end; ++i) {
        const double longest = a.edge[i].norm();
        if ((a.corner[i] - y).squaredNorm() > (near + longest) * (near + longest) || a.tangent[i].dot(t) > -0.5)
          continue;
        const double s = std::clamp(a.edge[i].dot(y - a.corner[i]) / std::max(longest * longest, 1e-12), 0., 1.);
        const Vec3 x = a.corner[i] + s * a.edge[i];
        if (const double d = (x - y).squaredNorm(); d < best)
          best = d, at = x, along = a.edge[i] / std::max(longest, 1e-12);
      }
    }
    if (best >= near * near) continue;
    out.from.push_back(y), out.to.push_back(at), out.along.push_back(along), out.apart.push_back(std::sqrt(best));
    out.length += b.share_mm[j], sum += b.share_mm[j] * best;
  }
  if (out.length > 0) out.residual = std::sqrt(sum / out.length);
  return out;
}

/// The same within three times the usual distance, no more than
/// `widest`: without what only comes near where the common curve ends.
Together together_closely(const SortedPiece& a, const SortedPiece& b, const Isometry3d& T, double widest) {
  Together t = together(a, b, T, widest);
  if (t.from.empty()) return t;
  std::nth_element(t.apart.begin(), t.apart.begin() + std::ptrdiff_t(t.apart.size() / 2), t.apart.end());
  const double near = std::max(kExact_mm, 3 * t.apart[t.apart.size() / 2]);
  return near < widest ? together(a, b, T, near) : t;
}

struct Fit {
  Isometry3d T;
  double length = 0, residual = 0;
  double worth() const { return length / (0.05 + residual); }
};
/// Nearest places, within a distance that shrinks to three times the usual one: what only comes near where
/// the common curve ends is left out.
Fit fit(const SortedPiece& a, const SortedPiece& b, Isometry3d T, int rounds = 60) {
  const double counted = together_mm(a, b), widest = std::max(4., counted);
  double near = widest;
  for (int round = 0; round < rounds; ++round) {
    Together t = together(a, b, T, near);
    if (t.from.size() < 8) break;
    const Isometry3d by = towards_lines(t.from, t.to, t.along);
    const double move = (by * b.middle_at(T) - b.middle_at(T)).norm() + degrees(by);
    T = by * T;
    std::nth_element(t.apart.begin(), t.apart.begin() + std::ptrdiff_t(t.apart.size() / 2), t.apart.end());
    near = std::max({kExact_mm, 3 * t.apart[t.apart.size() / 2], near > counted ? 0.8 * near : 0.});
    near = std::min(near, widest);
    if (move < 1e-7 && near <= counted) break;
  }
  const Together end = together_closely(a, b, T, counted);
  return {T, end.length, end.residual};
}

/// Deepest place of one within the other.
double depth(const SortedPiece& a, const SortedPiece& b, const Isometry3d& b_in_a) {
  double most = 0;
  for (int side : {0, 1}) {
    const SortedPiece &p = side ? b : a, &q = side ? a : b;
    const Isometry3d T = side ? Isometry3d(b_in_a.inverse()) : b_in_a;
    for (const Vec3& y : q.shape.surface.X_mm) {
      const Vec3 x = T * y;
      if ((x.array() < p.shape.lo_mm.array()).any() || (x.array() > p.shape.hi_mm.array()).any() ||
          !p.shape.surface.contains(x))
        continue;
      most = std::max(most, p.shape.surface.bvh.closest(x).distance_mm);
    }
  }
  return most;
}

bool same(const Isometry3d& s, const Isometry3d& t, const Vec3& about, double mm, double deg) {
  return (s * about - t * about).norm() <= mm && degrees(s.inverse() * t) <= deg;
}

SortedPiece describe(const simplex::Mesh& m) {
  SortedPiece p;
  p.rings = cut_rings(m);
  p.shape = fragment_shape(m, 0);
  for (const Ring& r : p.rings) {
    const size_t n = r.corner_mm.size();
    for (size_t i = 0; i < n; ++i) {
      const Vec3 &before = r.corner_mm[(i + n - 1) % n], &x = r.corner_mm[i], &after = r.corner_mm[(i + 1) % n];
      p.corner.push_back(x), p.edge.push_back(after - x);
      p.tangent.push_back((after - before).normalized());
      p.share_mm.push_back(0.5 * ((after - x).norm() + (x - before).norm()));
      if (i % kStretch == 0) p.stretch.push_back({p.corner.size() - 1, 0});
      Stretch& last = p.stretch.back();
      last.end = p.corner.size(), last.lo_mm = last.lo_mm.cwiseMin(x.cwiseMin(after)),
      last.hi_mm = last.hi_mm.cwiseMax(x.cwiseMax(after));
    }
    p.noise_mm = std::max(p.noise_mm, r.noise_mm);
  }
  return p;
}

/// How the walls lie: area of b's wall that lies on a's, facing it, and the distance there (rms).
struct Contact {
  double area_mm2 = 0, residual_mm = 0;
};
Contact contact(const SortedPiece& a, const SortedPiece& b, const Isometry3d& T, double near) {
  Contact c;
  if (a.shape.walls.empty()) return c;
  for (const WallPoint& p : b.shape.wall) {
    const Vec3 x = T * p.x_mm;
    if ((x.array() < a.shape.lo_mm.array() - near).any() || (x.array() > a.shape.hi_mm.array() + near).any()) continue;
    const Bvh::Closest at = a.shape.walls.closest(x, near);
    if (at.triangle < 0 || a.shape.surface.normal(at.triangle).dot(T.linear() * p.normal) > -0.7) continue;
    c.area_mm2 += p.area_mm2, c.residual_mm += p.area_mm2 * at.distance_mm * at.distance_mm;
  }
  if (c.area_mm2 > 0) c.residual_mm = std::sqrt(c.residual_mm / c.area_mm2);
  return c;
}

/// Empty when a fit stands; else why not.
std::string doubt(const SortedPiece& a, const SortedPiece& b, const Fit& f, const SortingRules& rules) {
  if (!(f.length > 0)) return "their cut rings do not run together";
  if (f.length < rules.least_length_mm || f.residual > rules.most_residual_mm)
    return text("their cut rings run together for %.0f mm, %.2f mm apart", f.length, f.residual);
  const double most = kExplained * explained(a, b) + kUnexplained_mm;
  if (f.residual > most)
    return text("their cut rings lie %.2f mm apart; their noise explains %.2f mm", f.residual, most);
  // Two tables of a bone that is kThinnest_mm thick, at least, have so much wall between them.
  constexpr double kThinnest_mm = 1;
  const double wall = 0.5 * f.length * kThinnest_mm;
  const double touch = kTouch_mm + 2.5 * explained(a, b);
  const Contact there = contact(a, b, f.T, touch), back = contact(b, a, f.T.inverse(), touch),
                &c = there.area_mm2 > back.area_mm2 ? there : back;
  if (c.area_mm2 < wall)
    return text("their cut surfaces touch on %.0f mm^2; at least %.0f mm^2 was expected", c.area_mm2, wall);
  if (const double apart = rules.most_residual_mm + explained(a, b); c.residual_mm > apart)
    return text("their cut surfaces lie %.2f mm apart; at most %.2f mm was expected", c.residual_mm, apart);
  if (const double d = depth(a, b, f.T) - 4 * explained(a, b); d > rules.most_depth_mm)
    return text("bone would lie %.1f mm within bone (rings together for %.0f mm)", d, f.length);
  return "";
}

/// All verified ways of b to a, best first; or why there is none.
std::vector<Fit> ways_of(const SortedPiece& a, const SortedPiece& b, const SortingRules& rules, std::string& why) {
  const Vec3 middle = b.middle();
  std::vector<RingWay> ways;
  for (const Ring& p : a.rings)
    for (const Ring& q : b.rings)
      for (RingWay& w : ring_ways(p, q, middle, kTried)) ways.push_back(w);
  why = "no way to lay their cut rings together";
  if (ways.empty()) return {};
  std::stable_sort(ways.begin(), ways.end(), [](const RingWay& s, const RingWay& t) { return s.score > t.score; });
  // Ways that come to the same place are one; the tables of a bone find it twice.
  const auto keep = [&](std::vector<Fit>& fits, const Fit& f, double mm, double deg) {
    for (Fit& g : fits)
      if (same(f.T, g.T, middle, mm, deg)) {
        if (f.worth() > g.worth()) g = f;
        return;
      }
    fits.push_back(f);
  };
  const auto by_worth = [](const Fit& f, const Fit& g) { return f.worth() > g.worth(); };
  std::vector<Fit> rough, fits;
  for (size_t k = 0; k < ways.size() && rough.size() < kTried; ++k) {
    if (std::any_of(rough.begin(), rough.end(), [&](const Fit& g) { return same(ways[k].T, g.T, middle, 1, 2); }))
      continue;
    keep(rough, fit(a, b, ways[k].T, 8), 1, 2);
  }
  std::stable_sort(rough.begin(), rough.end(), by_worth);
  if (rough.size() > kFitted) rough.resize(kFitted);
  for (const Fit& f : rough) keep(fits, fit(a, b, f.T), kOne_mm, kOne_deg);
  std::stable_sort(fits.begin(), fits.end(), by_worth);
  std::vector<Fit> stand;
  for (const Fit& f : fits)
    if (const std::string bad = doubt(a, b, f, rules); bad.empty())
      stand.push_back(f);
    else if (&f == &fits[0])
      why = bad;
  return stand;
}

/// Another way that is as good: nearly as long, and what it lies off more than the best one is less than kWorse_mm.
bool ambiguous(const std::vector<Fit>& f) {
  constexpr double kWorse_mm = 0.15;
  return std::any_of(f.begin() + (f.empty() ? 0 : 1), f.end(), [&](const Fit& g) {
    return g.length > 0.8 * f[0].length &&
           g.residual * g.residual < f[0].residual * f[0].residual + kWorse_mm * kWorse_mm;
  });
}

/// Puts groups together.
class Assembly {
 public:
  Assembly(const std::vector<SortedPiece>& pieces, const SortingRules& rules, Sorting& out)
      : p_(pieces), rules_(rules), o_(out) {
    o_.pose.assign(p_.size(), Isometry3d::Identity());
    for (size_t i = 0; i < p_.size(); ++i) o_.group.push_back(int32_t(i));
  }
  bool one(size_t a, size_t b) const { return o_.group[a] == o_.group[b]; }
  /// From the frame of b's group to that of a's, when b lies at b_in_a.
  Isometry3d carry(size_t a, size_t b, const Isometry3d& b_in_a) const {
    return o_.pose[a] * b_in_a * o_.pose[b].inverse();
  }
  template <class Visit>
  void between(size_t a, size_t b, const Isometry3d& by, Visit&& visit) const {
    for (size_t i = 0; i < p_.size(); ++i)
      for (size_t j = 0; j < p_.size(); ++j)
        if (one(i, a) && one(j, b)) visit(p_[i], p_[j], Isometry3d(o_.pose[i].inverse() * by * o_.pose[j]));
  }
  double deepest(size_t a, size_t b, const Isometry3d& by) const {
    double most = 0;
    between(a, b, by, [&](const SortedPiece& p, const SortedPiece& q, const Isometry3d& T) {
      most = std::max(most, depth(p, q, T));
    });
    return most;
  }
  /// Length of all rings of the two groups that would run together.
  double length(size_t a, size_t b, const Isometry3d& by) const {
    double sum = 0;
    between(a, b, by, [&](const SortedPiece& p, const SortedPiece& q, const Isometry3d& T) {
      sum += together(p, q, T, together_mm(p, q)).length;
    });
    return sum;
  }
  void put(size_t a, size_t b, const Isometry3d& by) {
    const int32_t from = o_.group[b], to = o_.group[a], low = std::min(from, to);
    for (size_t i = 0; i < p_.size(); ++i) {
      if (o_.group[i] == from)
        o_.pose[i] = by * o_.pose[i], o_.group[i] = low;
      else if (o_.group[i] == to)
        o_.group[i] = low;
    }
    const Isometry3d back = o_.pose[size_t(low)].inverse();
    for (size_t i = 0; i < p_.size(); ++i)
      if (o_.group[i] == low) o_.pose[i] = i == size_t(low) ? Isometry3d::Identity() : Isometry3d(back * o_.pose[i]);
  }
  /// Puts the groups together if that goes: they settle, and then no bone may lie deep within bone. Else nothing has
  /// changed; the answer is how deep.
  double try_to_put(size_t a, size_t b, const Isometry3d& by, double most) {
    const std::vector<Isometry3d> pose = o_.pose;
    const std::vector<int32_t> group = o_.group;
    put(a, b, by);
    settle(o_.group[a]);
    double deep = 0;
    for (size_t i = 0; i < p_.size(); ++i)
      for (size_t j = 0; j < p_.size(); ++j)
        if (group[i] == group[a] && group[j] == group[b])
          deep = std::max(deep, depth(p_[i], p_[j], o_.pose[i].inverse() * o_.pose[j]) - 4 * explained(p_[i], p_[j]));
    if (deep <= most) return 0;
    o_.pose = pose, o_.group = group;
    return deep;
  }
  /// All pieces of a group, each towards all that it touches, the first kept in place.
  void settle(int32_t group) {
    double widest = kSettle_mm;
    for (int round = 0; round < kRounds; ++round, widest *= 0.8)
      for (size_t j = 0; j < p_.size(); ++j) {
        if (o_.group[j] != group || size_t(group) == j) continue;
        Together all;
        for (size_t i = 0; i < p_.size(); ++i) {
          if (i == j || !one(i, j)) continue;
          const Together t = together_closely(p_[i], p_[j], o_.pose[i].inverse() * o_.pose[j],
                                              std::max(widest, together_mm(p_[i], p_[j])));
          for (size_t k = 0; k < t.from.size(); ++k)
            all.from.push_back(o_.pose[i] * t.from[k]), all.to.push_back(o_.pose[i] * t.to[k]),
                all.along.push_back(o_.pose[i].linear() * t.along[k]);
        }
        if (all.from.size() >= 8) o_.pose[j] = towards_lines(all.from, all.to, all.along) * o_.pose[j];
      }
  }
  /// A pair of one group, where it lies: rings and walls together there.
  std::string stands(size_t a, size_t b, Match& m) const {
    const Isometry3d T = o_.pose[a].inverse() * o_.pose[b];
    const Together t = together_closely(p_[a], p_[b], T, together_mm(p_[a], p_[b]));
    m.b_in_a = T, m.length_mm = t.length, m.residual_mm = t.residual;
    return doubt(p_[a], p_[b], {T, t.length, t.residual}, rules_);
  }

 private:
  const std::vector<SortedPiece>& p_;
  const SortingRules& rules_;
  Sorting& o_;
};

}  // namespace

Sorting sort_fragments(const std::vector<simplex::Mesh>& meshes, const SortingRules& rules) {
  std::vector<SortedPiece> pieces;
  for (const simplex::Mesh& m : meshes) pieces.push_back(describe(m));
  Sorting out;
  Assembly assembly(pieces, rules, out);
  struct Pair {
    size_t a, b;
    std::vector<Fit> ways;
    std::string why;
  };
  std::vector<Pair> pairs;
  for (size_t i = 0; i < pieces.size(); ++i)
    for (size_t j = i + 1; j < pieces.size(); ++j) {
      pairs.push_back({i, j, {}, ""});
      pairs.back().ways = ways_of(pieces[i], pieces[j], rules, pairs.back().why);
    }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& s, const Pair& t) {
    return (s.ways.empty() ? 0 : s.ways[0].worth()) > (t.ways.empty() ? 0 : t.ways[0].worth());
  });
  // What fits in one way only, the best first.
  for (Pair& p : pairs) {
    if (p.ways.empty()) continue;
    if (ambiguous(p.ways)) {
      p.why = text("it fits in several places: for %.0f mm and for %.0f mm", p.ways[0].length, p.ways[1].length);
      continue;
    }
    if (assembly.one(p.a, p.b)) continue;
    const Isometry3d by = assembly.carry(p.a, p.b, p.ways[0].T);
    if (const double d = assembly.try_to_put(p.a, p.b, by, rules.most_depth_mm); d > 0)
      p.why = text("with it, bone would lie %.1f mm within bone (rings together for %.0f mm)", d, p.ways[0].length);
  }
  // What fits in several: where all neighbours fit too, if that is clearly one way.
  for (bool any = true; any;) {
    any = false;
    for (const Pair& p : pairs) {
      if (p.ways.size() < 2 || assembly.one(p.a, p.b)) continue;
      double best = 0, second = 0;
      Isometry3d by;
      for (const Fit& f : p.ways) {
        const Isometry3d way = assembly.carry(p.a, p.b, f.T);
        const double length = assembly.length(p.a, p.b, way);
        if (length <= second || assembly.deepest(p.a, p.b, way) > rules.most_depth_mm + kSettle_mm) continue;
        if (length > best)
          second = best, best = length, by = way;
        else
          second = length;
      }
      if (best < 1.25 * second || best == 0) continue;
      any |= assembly.try_to_put(p.a, p.b, by, rules.most_depth_mm) == 0;
    }
  }
  // Every pair where it lies now.
  for (const Pair& p : pairs) {
    Match m;
    m.a = int32_t(p.a), m.b = int32_t(p.b);
    const std::string bad = assembly.one(p.a, p.b) ? assembly.stands(p.a, p.b, m) : "";
    if (assembly.one(p.a, p.b) && bad.empty())
      out.matches.push_back(m);
    else
      out.refused.push_back({m.a, m.b,
                             !bad.empty()     ? bad
                             : !p.why.empty() ? p.why
                                              : "it contradicts pairs that fit better"});
  }
  std::stable_sort(out.matches.begin(), out.matches.end(),
                   [](const Match& s, const Match& t) { return s.length_mm > t.length_mm; });
  return out;
}

std::vector<simplex::Mesh> pieces_of(const Bones& bones, std::vector<int32_t>* ids) {
  std::vector<simplex::Mesh> out;
  if (ids) ids->clear();
  for (const Fragment& f : bones.fragments()) {
    out.push_back(simplex::extract_component(bones.mesh(), f.vertex));
    for (Vec3& x : out.back().x_mm) x = f.pose * x;
    out.back().before_mm = out.back().x_mm;
    if (ids) ids->push_back(f.id);
  }
  return out;
}

}  // namespace limberg::bone
