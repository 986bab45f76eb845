#include "sim/bone/sorting.h"

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
constexpr double kTogether_mm = 0.6;  // rings that run together in the end
constexpr size_t kFitted = 12;        // the best ways that are fitted

struct Piece {
  std::vector<Ring> rings;
  FragmentShape shape;
  std::vector<Vec3> corner, edge;     // of all rings: places, and edge vectors to the next
  std::vector<Vec3> tangent;
  std::vector<double> share_mm;       // of the ring's length that a corner stands for
};

Isometry3d rigid_fit(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  Eigen::Matrix3Xd A(3, Eigen::Index(from.size())), B(3, Eigen::Index(to.size()));
  for (size_t i = 0; i < from.size(); ++i) A.col(Eigen::Index(i)) = from[i], B.col(Eigen::Index(i)) = to[i];
  Isometry3d T;
  T.matrix() = Eigen::umeyama(A, B, false);
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

/// Corners of b on the rings of a, where they are near and run against each other.
struct Fit {
  Isometry3d T;
  double length = 0, residual = 0;
};
Fit fit(const Piece& a, const Piece& b, Isometry3d T) {
  Fit out;
  double near = 4;  // mm, shrinking
  for (int round = 0; round < 40; ++round) {
    std::vector<Vec3> from, to;
    double length = 0, sum = 0;
    for (size_t j = 0; j < b.corner.size(); ++j) {
      const Vec3 y = T * b.corner[j], t = T.linear() * b.tangent[j];
      double best = near * near;
      Vec3 at;
      for (size_t i = 0; i < a.corner.size(); ++i) {
        const double longest = a.edge[i].norm();
        if ((a.corner[i] - y).squaredNorm() > (near + longest) * (near + longest) || a.tangent[i].dot(t) > -0.5) continue;
        const double s = std::clamp(a.edge[i].dot(y - a.corner[i]) / std::max(longest * longest, 1e-12), 0., 1.);
        const Vec3 x = a.corner[i] + s * a.edge[i];
        if (const double d = (x - y).squaredNorm(); d < best) best = d, at = x;
      }
      if (best >= near * near) continue;
      from.push_back(b.corner[j]), to.push_back(at);
      length += b.share_mm[j], sum += b.share_mm[j] * best;
    }
    out.T = T, out.length = length, out.residual = length > 0 ? std::sqrt(sum / length) : 1e9;
    if (from.size() < 8) return out;
    const Isometry3d next = rigid_fit(from, to);
    const double move = (next.translation() - T.translation()).norm() + degrees(next.inverse() * T);
    T = next;
    near = std::max(kTogether_mm, 0.8 * near);
    if (move < 1e-7 && near <= kTogether_mm) break;
  }
  return out;
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

/// The best verified way of b to a, or why there is none.
std::string match(const Piece& a, const Piece& b, const SortingRules& rules, Match& out) {
  std::vector<Way> ways;
  for (const Ring& p : a.rings)
    for (const Ring& q : b.rings)
      for (size_t i = 0; i < p.x_mm.size(); i += 2) {
        Way best;
        for (size_t j = 0; j < q.x_mm.size(); ++j)
          if (const Way w = lay(p, i, q, j); w.score > best.score) best = w;
        if (best.score > 0) ways.push_back(best);
      }
  std::stable_sort(ways.begin(), ways.end(), [](const Way& s, const Way& t) { return s.score > t.score; });
  if (ways.empty()) return "no cut rings";
  const Vec3 middle = 0.5 * (b.shape.lo_mm + b.shape.hi_mm);
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
  // Longest together first; those that hold the residual before those that do not.
  const auto good = [&](const Fit& f) { return f.residual <= rules.most_residual_mm && f.length >= rules.least_length_mm; };
  std::stable_sort(fits.begin(), fits.end(), [&](const Fit& f, const Fit& g) { return good(f) != good(g) ? good(f) : f.length > g.length; });
  std::vector<Fit> stand;
  std::string why;
  for (const Fit& f : fits) {
    if (!good(f)) {
      if (why.empty()) why = text("rings run together for %.0f mm only, %.2f mm apart", f.length, f.residual);
      continue;
    }
    if (const double d = depth(a, b, f.T); d > rules.most_depth_mm) {
      why = text("bone would lie %.1f mm within bone (rings together for %.0f mm)", d, f.length);
      continue;
    }
    stand.push_back(f);
  }
  if (stand.empty()) return why.empty() ? "no way to lay the rings together" : why;
  if (stand.size() > 1 && stand[1].length > 0.8 * stand[0].length && stand[1].residual < 2 * stand[0].residual + 0.05)
    return text("it fits in several places: for %.0f mm and for %.0f mm", stand[0].length, stand[1].length);
  out.b_in_a = stand[0].T, out.length_mm = stand[0].length, out.residual_mm = stand[0].residual;
  return "";
}

}  // namespace

Sorting sort_fragments(const std::vector<simplex::Mesh>& meshes, const SortingRules& rules) {
  std::vector<Piece> pieces;
  for (const simplex::Mesh& m : meshes) pieces.push_back(describe(m));
  const size_t n = pieces.size();
  Sorting out;
  out.pose.assign(n, Isometry3d::Identity());
  for (size_t i = 0; i < n; ++i) out.group.push_back(int32_t(i));
  std::vector<Match> found;
  for (size_t i = 0; i < n; ++i)
    for (size_t j = i + 1; j < n; ++j) {
      Match m;
      m.a = int32_t(i), m.b = int32_t(j);
      if (std::string why = match(pieces[i], pieces[j], rules, m); why.empty()) found.push_back(m);
      else out.refused.push_back({m.a, m.b, why});
    }
  std::stable_sort(found.begin(), found.end(), [](const Match& s, const Match& t) { return s.length_mm > t.length_mm; });
  for (const Match& m : found) {
    const size_t a = size_t(m.a), b = size_t(m.b);
    const Isometry3d b_now = out.pose[a] * m.b_in_a;  // in the frame of a's group
    const Vec3 middle = 0.5 * (pieces[b].shape.lo_mm + pieces[b].shape.hi_mm);
    if (out.group[a] == out.group[b]) {
      // Three pairs in a ring: the third has to say the same. Small errors of two add up.
      if (same(out.pose[b], b_now, middle, 3 * rules.same_mm, 3 * rules.same_deg)) out.matches.push_back(m);
      else out.refused.push_back({m.a, m.b, "it contradicts pairs that fit for longer"});
      continue;
    }
    // All of b's group goes to a's; nothing of one may lie within the other.
    const Isometry3d by = b_now * out.pose[b].inverse();
    double deep = 0;
    for (size_t i = 0; i < n; ++i)
      for (size_t j = 0; j < n; ++j)
        if (out.group[i] == out.group[a] && out.group[j] == out.group[b]) deep = std::max(deep, depth(pieces[i], pieces[j], out.pose[i].inverse() * by * out.pose[j]));
    if (deep > rules.most_depth_mm) {
      out.refused.push_back({m.a, m.b, text("with it, bone would lie %.1f mm within bone (rings together for %.0f mm)", deep, m.length_mm)});
      continue;
    }
    const int32_t from = out.group[b], to = out.group[a], low = std::min(from, to);
    for (size_t i = 0; i < n; ++i) {
      if (out.group[i] == from) out.pose[i] = by * out.pose[i], out.group[i] = low;
      else if (out.group[i] == to) out.group[i] = low;
    }
    const Isometry3d back = out.pose[size_t(low)].inverse();
    for (size_t i = 0; i < n; ++i)
      if (out.group[i] == low) out.pose[i] = i == size_t(low) ? Isometry3d::Identity() : Isometry3d(back * out.pose[i]);
    out.matches.push_back(m);
  }
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
