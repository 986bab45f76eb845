#include "sim/bone/sorting.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sim/bone/bones.h"
#include "sim/bone/rings.h"
#include "sim/bone/shape.h"
#include "sim/simplex/dual.h"

namespace limberg::bone {
namespace {

using Eigen::Isometry3d;

constexpr double kNear_mm = 1.5;      // rings run together while they are no further apart
constexpr double kFan = 0.08;         // and per mm of arc from where they were laid on each other: frames are good to 5 degrees
constexpr double kLongest_mm = 45;    // of the run to either side that is looked at
constexpr double kTogether_mm = 0.6;  // rings that are counted as running together
constexpr double kExact_mm = 0.05;    // a fit looks at least so far
constexpr size_t kFitted = 12;        // the best ways that are fitted

struct Piece {
  std::vector<Ring> rings;
  FragmentShape shape;
  std::vector<Vec3> corner, edge;     // of all rings: places, and edge vectors to the next
  std::vector<Vec3> tangent;
  std::vector<double> share_mm;       // of the ring's length that a corner stands for
  Vec3 middle() const { return 0.5 * (shape.lo_mm + shape.hi_mm); }
  Vec3 middle_at(const Isometry3d& T) const { return T * middle(); }
};

/// The small motion that brings the places nearest to the lines (least squares of the distances across them: a curve may
/// slide along itself, where nearest places would hold it back). Gauss-Newton; rotation about `about`.
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
  if (angle > 0) T.linear() = Eigen::AngleAxisd(angle, w.normalized()).toRotationMatrix();
  T.translation() = about + d.tail<3>() - T.linear() * about;
  return T;
}

double degrees(const Isometry3d& T) { return Eigen::AngleAxisd(Mat3(T.linear())).angle() * 180 / M_PI; }

struct Way {
  double score = 0;
  Isometry3d T;  // b in a
};

/// Lays place j of ring q on place i of ring p and follows both by arc length.
Way lay(const Ring& p, size_t i, const Ring& q, size_t j) {
  Way w;
  Mat3 A, B;
  A << p.tangent[i], p.normal[i], p.tangent[i].cross(p.normal[i]);
  B << -q.tangent[j], q.normal[j], -q.tangent[j].cross(q.normal[j]);
  w.T = Isometry3d::Identity();
  w.T.linear() = A * B.transpose();
  w.T.translation() = p.x_mm[i] - w.T.linear() * q.x_mm[j];
  const int np = int(p.x_mm.size()), nq = int(q.x_mm.size());
  for (int side : {1, -1})
    for (int k = 2; k * p.step_mm < kLongest_mm && 2 * k < np; k += 2) {
      const Vec3& x = p.x_mm[size_t(((int(i) + side * k) % np + np) % np)];
      // Steps differ a little: the same arc on q, the other way round.
      const int l = int(std::lround(k * p.step_mm / q.step_mm));
      const Vec3& y = q.x_mm[size_t(((int(j) - side * l) % nq + nq) % nq)];
      const double d = (w.T * y - x).norm(), most = kNear_mm + kFan * k * p.step_mm;
      if (d > most) break;
      w.score += 2 * p.step_mm * (1 - d / most);
    }
  return w;
}

/// Corners of b on the rings of a, where they are nearer than that and run against each other.
struct Together {
  std::vector<Vec3> from, to, along;  // corners of b where they are now, the places on a's rings, a's tangents there
  std::vector<double> apart;
  double length = 0, residual = 1e9;
};
Together together(const Piece& a, const Piece& b, const Isometry3d& T, double near) {
  Together out;
  double sum = 0;
  for (size_t j = 0; j < b.corner.size(); ++j) {
    const Vec3 y = T * b.corner[j], t = T.linear() * b.tangent[j];
    double best = near * near;
    Vec3 at, along;
    for (size_t i = 0; i < a.corner.size(); ++i) {
      const double longest = a.edge[i].norm();
      if ((a.corner[i] - y).squaredNorm() > (near + longest) * (near + longest) || a.tangent[i].dot(t) > -0.5) continue;
      const double s = std::clamp(a.edge[i].dot(y - a.corner[i]) / std::max(longest * longest, 1e-12), 0., 1.);
      const Vec3 x = a.corner[i] + s * a.edge[i];
      if (const double d = (x - y).squaredNorm(); d < best) best = d, at = x, along = a.edge[i] / std::max(longest, 1e-12);
    }
    if (best >= near * near) continue;
    out.from.push_back(y), out.to.push_back(at), out.along.push_back(along), out.apart.push_back(std::sqrt(best));
    out.length += b.share_mm[j], sum += b.share_mm[j] * best;
  }
  if (out.length > 0) out.residual = std::sqrt(sum / out.length);
  return out;
}

struct Fit {
  Isometry3d T;
  double length = 0, residual = 0;
};
/// Nearest places, within a distance that shrinks to three times the usual one: what only comes near where
/// the common curve ends is left out.
Fit fit(const Piece& a, const Piece& b, Isometry3d T) {
  double near = 4;  // mm
  for (int round = 0; round < 60; ++round) {
    Together t = together(a, b, T, near);
    if (t.from.size() < 8) break;
    const Isometry3d by = towards_lines(t.from, t.to, t.along);
    const double move = (by * b.middle_at(T) - b.middle_at(T)).norm() + degrees(by);
    T = by * T;
    std::nth_element(t.apart.begin(), t.apart.begin() + std::ptrdiff_t(t.apart.size() / 2), t.apart.end());
    near = std::max({kExact_mm, 3 * t.apart[t.apart.size() / 2], near > kTogether_mm ? 0.8 * near : 0.});
    near = std::min(near, 4.);
    if (move < 1e-7 && near <= kTogether_mm) break;
  }
  const Together end = together(a, b, T, kTogether_mm);
  return {T, end.length, end.residual};
}

/// Deepest place of one within the other.
double depth(const Piece& a, const Piece& b, const Isometry3d& b_in_a) {
  double most = 0;
  for (int side : {0, 1}) {
    const Piece &p = side ? b : a, &q = side ? a : b;
    const Isometry3d T = side ? Isometry3d(b_in_a.inverse()) : b_in_a;
    for (const Vec3& y : q.shape.surface.X_mm) {
      const Vec3 x = T * y;
      if ((x.array() < p.shape.lo_mm.array()).any() || (x.array() > p.shape.hi_mm.array()).any() || !p.shape.surface.contains(x)) continue;
      most = std::max(most, p.shape.surface.bvh.closest(x).distance_mm);
    }
  }
  return most;
}

bool same(const Isometry3d& s, const Isometry3d& t, const Vec3& about, double mm, double deg) {
  return (s * about - t * about).norm() <= mm && degrees(s.inverse() * t) <= deg;
}

Piece describe(const simplex::Mesh& m) {
  Piece p;
  p.rings = cut_rings(m);
  p.shape = fragment_shape(m, 0);
  for (const Ring& r : p.rings) {
    const size_t n = r.corner_mm.size();
    for (size_t i = 0; i < n; ++i) {
      const Vec3 &before = r.corner_mm[(i + n - 1) % n], &x = r.corner_mm[i], &after = r.corner_mm[(i + 1) % n];
      p.corner.push_back(x), p.edge.push_back(after - x);
      p.tangent.push_back((after - before).normalized());
      p.share_mm.push_back(0.5 * ((after - x).norm() + (x - before).norm()));
    }
  }
  return p;
}

std::string text(const char* format, double a, double b) {
  char s[160];
  std::snprintf(s, sizeof s, format, a, b);
  return s;
}

/// All verified ways of b to a, best first; or why there is none.
std::vector<Fit> ways_of(const Piece& a, const Piece& b, const SortingRules& rules, std::string& why) {
  std::vector<Way> ways;
  for (const Ring& p : a.rings)
    for (const Ring& q : b.rings)
      for (size_t i = 0; i < p.x_mm.size(); i += 2) {
        Way best;
        for (size_t j = 0; j < q.x_mm.size(); ++j)
          if (const Way w = lay(p, i, q, j); w.score > best.score) best = w;
        if (best.score > 0) ways.push_back(best);
      }
  why = "no way to lay their cut rings together";
  if (ways.empty()) return {};
  std::stable_sort(ways.begin(), ways.end(), [](const Way& s, const Way& t) { return s.score > t.score; });
  const Vec3 middle = b.middle();
  std::vector<Way> different;
  for (const Way& w : ways) {
    if (different.size() >= kFitted || w.score < 0.4 * ways[0].score) break;
    if (std::none_of(different.begin(), different.end(), [&](const Way& d) { return same(w.T, d.T, middle, 4, 8); })) different.push_back(w);
  }
  std::vector<Fit> fits;
  for (const Way& w : different) {
    const Fit f = fit(a, b, w.T);
    if (std::none_of(fits.begin(), fits.end(), [&](const Fit& g) { return same(f.T, g.T, middle, rules.same_mm, rules.same_deg); })) fits.push_back(f);
  }
  std::stable_sort(fits.begin(), fits.end(), [](const Fit& f, const Fit& g) { return f.length > g.length; });
  std::vector<Fit> stand;
  for (const Fit& f : fits) {
    if (f.length < rules.least_length_mm || f.residual > rules.most_residual_mm) {
      if (&f == &fits[0]) why = text("their cut rings run together for %.0f mm, %.2f mm apart", f.length, f.residual);
    } else if (const double d = depth(a, b, f.T); d > rules.most_depth_mm) {
      why = text("bone would lie %.1f mm within bone (rings together for %.0f mm)", d, f.length);
    } else {
      stand.push_back(f);
    }
  }
  return stand;
}

/// Another way that is as good: nearly as long, and not clearly worse in its residual.
bool ambiguous(const std::vector<Fit>& f) {
  return f.size() > 1 && f[1].length > 0.8 * f[0].length && f[1].residual < 1.5 * f[0].residual + 0.03;
}

/// Puts groups together.
class Assembly {
 public:
  Assembly(const std::vector<Piece>& pieces, const SortingRules& rules, Sorting& out) : p_(pieces), rules_(rules), o_(out) {
    o_.pose.assign(p_.size(), Isometry3d::Identity());
    for (size_t i = 0; i < p_.size(); ++i) o_.group.push_back(int32_t(i));
  }
  bool one(size_t a, size_t b) const { return o_.group[a] == o_.group[b]; }
  /// From the frame of b's group to that of a's, when b lies at b_in_a.
  Isometry3d carry(size_t a, size_t b, const Isometry3d& b_in_a) const { return o_.pose[a] * b_in_a * o_.pose[b].inverse(); }
  template <class Visit>
  void between(size_t a, size_t b, const Isometry3d& by, Visit&& visit) const {
    for (size_t i = 0; i < p_.size(); ++i)
      for (size_t j = 0; j < p_.size(); ++j)
        if (one(i, a) && one(j, b)) visit(p_[i], p_[j], Isometry3d(o_.pose[i].inverse() * by * o_.pose[j]));
  }
  double deepest(size_t a, size_t b, const Isometry3d& by) const {
    double most = 0;
    between(a, b, by, [&](const Piece& p, const Piece& q, const Isometry3d& T) { most = std::max(most, depth(p, q, T)); });
    return most;
  }
  /// Length of all rings of the two groups that would run together.
  double length(size_t a, size_t b, const Isometry3d& by) const {
    double sum = 0;
    between(a, b, by, [&](const Piece& p, const Piece& q, const Isometry3d& T) { sum += together(p, q, T, kTogether_mm).length; });
    return sum;
  }
  void put(size_t a, size_t b, const Isometry3d& by) {
    const int32_t from = o_.group[b], to = o_.group[a], low = std::min(from, to);
    for (size_t i = 0; i < p_.size(); ++i) {
      if (o_.group[i] == from) o_.pose[i] = by * o_.pose[i], o_.group[i] = low;
      else if (o_.group[i] == to) o_.group[i] = low;
    }
    const Isometry3d back = o_.pose[size_t(low)].inverse();
    for (size_t i = 0; i < p_.size(); ++i)
      if (o_.group[i] == low) o_.pose[i] = i == size_t(low) ? Isometry3d::Identity() : Isometry3d(back * o_.pose[i]);
  }
  /// A pair of one group, where it lies: the rings run together there.
  bool stands(size_t a, size_t b, Match& m) const {
    const Isometry3d T = o_.pose[a].inverse() * o_.pose[b];
    const Fit f = fit(p_[a], p_[b], T);
    if (f.length < rules_.least_length_mm || f.residual > rules_.most_residual_mm || !same(f.T, T, p_[b].middle(), 2 * rules_.same_mm, 2 * rules_.same_deg)) return false;
    m.b_in_a = f.T, m.length_mm = f.length, m.residual_mm = f.residual;
    return true;
  }

 private:
  const std::vector<Piece>& p_;
  const SortingRules& rules_;
  Sorting& o_;
};

}  // namespace

Sorting sort_fragments(const std::vector<simplex::Mesh>& meshes, const SortingRules& rules) {
  std::vector<Piece> pieces;
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
    const double x = s.ways.empty() ? 0 : s.ways[0].length, y = t.ways.empty() ? 0 : t.ways[0].length;
    return x > y;
  });
  // What fits in one way only, the longest first.
  for (Pair& p : pairs) {
    if (p.ways.empty()) continue;
    if (ambiguous(p.ways)) {
      p.why = text("it fits in several places: for %.0f mm and for %.0f mm", p.ways[0].length, p.ways[1].length);
      continue;
    }
    if (assembly.one(p.a, p.b)) continue;
    const Isometry3d by = assembly.carry(p.a, p.b, p.ways[0].T);
    if (const double d = assembly.deepest(p.a, p.b, by); d > rules.most_depth_mm) p.why = text("with it, bone would lie %.1f mm within bone (rings together for %.0f mm)", d, p.ways[0].length);
    else assembly.put(p.a, p.b, by);
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
        if (length <= second || assembly.deepest(p.a, p.b, way) > rules.most_depth_mm) continue;
        if (length > best) second = best, best = length, by = way;
        else second = length;
      }
      if (best < 1.25 * second || best == 0) continue;
      assembly.put(p.a, p.b, by);
      any = true;
    }
  }
  // Every pair where it lies now.
  for (const Pair& p : pairs) {
    Match m;
    m.a = int32_t(p.a), m.b = int32_t(p.b);
    if (assembly.one(p.a, p.b) && assembly.stands(p.a, p.b, m)) out.matches.push_back(m);
    else out.refused.push_back({m.a, m.b, !p.ways.empty() && assembly.one(p.a, p.b) && p.why.empty() ? "it contradicts pairs that fit for longer" : p.why});
  }
  std::stable_sort(out.matches.begin(), out.matches.end(), [](const Match& s, const Match& t) { return s.length_mm > t.length_mm; });
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
