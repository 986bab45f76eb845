#include "sim/imaging/fit/fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/geometry/bvh.h"
#include "sim/imaging/fit/fit_parts.h"
#include "sim/skull/simplex/adapt.h"
#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"
#include "sim/skull/simplex/motion.h"

namespace limberg {
namespace {

using namespace simplex;
using namespace imaging;

constexpr int kRounds = 4, kScanRounds = 12;  // of opening, at most; in a scan rims go on in them
constexpr int kFind = 4;                      // iterations: the places of rims are found anew after so many
const Vec3 kNowhere = Vec3::Constant(1e300);
constexpr double kSmallRim = 12;  // spacings of a scan around

double mean_edge(const Mesh& m) {
  double sum = 0;
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.alive(v)) sum += (m.x_mm[size_t(v)] - m.x_mm[size_t(m.nbr[size_t(v)][0])]).norm() / m.vertices();
  return sum;
}

class Fitter {
 public:
  Fitter(Mesh& m, const Sight& sight, const Vec3& low, const Vec3& high, const FitSettings& s, Workers& w)
      : m_(m),
        sight_(sight),
        low_(low),
        high_(high),
        s_(s),
        workers_(w),
        motion_(w),
        topology_(m, sight),
        framed_(sight.heights() != nullptr) {}

  FitReport run() {
    const double longest = mean_edge(m_);
    for (int stage = 0; stage < s_.stages; ++stage) {
      const double t = s_.stages > 1 ? double(stage) / (s_.stages - 1) : 1;
      const double move = settle(t, s_.iterations, true);
      if (s_.progress) s_.progress(stage, m_.vertices(), move);
      if (stage + 1 < s_.stages)
        refine(std::max(s_.edge_mm, longest * elementary::pow(s_.edge_mm / longest,
                                                              double(stage + 1) / std::max(1, s_.stages - 2))),
               2, uint64_t(stage) + 1);
    }
    if (s_.open_ends) {
      look(1, range(1));
      framed_ = false, opening_ = true;
      const int rounds = sight_.knows_air() ? kRounds : kScanRounds;
      std::vector<std::string> notes;  // of what is still shut in the last round
      for (int round = 0, opened = 1; round < rounds && (opened > 0 || onwards_); ++round) {
        notes.clear();
        opened = open_blind(m_, blind_faces(), notes);
        if (opened == 0 && !onwards_) break;  // (rims that find more of a scan go on after the last opening)
        r_.holes += opened;
        compact(m_, true);
        // The rims settle, and the faces beside them.
        settle(1, s_.iterations / 2, true);
        refine(s_.edge_mm, 1, 100 + uint64_t(round));
        settle(1, s_.iterations / 2, true);
        look(1, range(1));
      }
      r_.notes = std::move(notes);
      if (r_.holes > 0 && sight_.knows_air()) {
        split_rims(m_, 1.5 * s_.edge_mm);
        compact(m_, true);
        settle(1, 2 * s_.iterations, false);  // the rims come to rest
      }
    }
    measure();
    r_.joined = topology_.joined, r_.cut = topology_.cut;
    r_.notes.insert(r_.notes.end(), topology_.notes.begin(), topology_.notes.end());
    r_.hole = places(m_, sight_, low_, high_, s_.skull);
    r_.vertices = m_.vertices(), r_.voxel_mm = sight_.voxel();
    return r_;
  }

 private:
  double range(double t) const {
    return std::max(2 * sight_.voxel(), s_.range_mm * elementary::pow(2 * sight_.voxel() / s_.range_mm, t));
  }

  void refine(double edge, int passes, uint64_t seed) {
    AdaptSettings a;
    a.edge_mm = edge, a.chord_mm = s_.chord_mm, a.passes = passes, a.seed = seed;
    Delta d;
    adapt(m_, a, d);
    compact(m_, true);
  }

  /// One stage; returns the longest move of its last iteration.
  double settle(double t, int iterations, bool topology) {
    Law law;
    ZoneLaw& z = law.zone[0];
    z.constraint = Constraint::angle, z.alpha = 0.5;
    z.rigidity = std::max(1, int(std::lround(8 * elementary::pow(1. / 8, t))));
    z.beta = 0.05 * elementary::pow(10, t);
    law.external_stiffness = 2;  // along the normal, and at rims towards the border of the data
    const double edge = mean_edge(m_);
    law.max_step_mm = std::min(0.25 * s_.range_mm, 0.5 * edge);
    law.metric_gain = s_.metric_gain;
    if (const Admission a = motion_.set_law(law); !a) throw InputError("", 0, a.refused);
    int still = 0;
    double move = 0;
    still_.assign(m_.nbr.size(), 0);
    const bool check = topology && t < 1;
    for (int i = 0; i < iterations && still < 10; ++i) {
      if (check && i % 5 == 0) {
        const int changes = topology_.joined + topology_.cut;
        topology_.check(edge, still_);
        if (topology_.joined + topology_.cut != changes) still_.resize(m_.nbr.size(), 0);
      }
      look(t, range(t));
      if (check)
        for (size_t v = 0; v < pull_.size(); ++v)
          if (still_[v] && m_.alive(int32_t(v))) {
            if (still_[v] == 2)
              pull_[v] = sight_.home(m_.x_mm[v], 0.5 * edge);
            else
              pull_[v].setZero(), m_.before_mm[v] = m_.x_mm[v];
          }
      to_border(z.beta, i % kFind == 0);
      move = motion_.step(m_, {pull_, {}}).max_move_mm;
      still = move < s_.still_mm ? still + 1 : 0;
      ++r_.iterations, r_.vertex_iterations += m_.vertices();
    }
    return move;
  }

  void look(double t, double range) {
    pull_.assign(m_.nbr.size(), Vec3::Zero());
    seen_.assign(m_.nbr.size(), 0);
    workers_.parallel_for(m_.nbr.size(), 256, [&](size_t b, size_t e) {
      for (size_t v = b; v < e; ++v) {
        if (!m_.alive(int32_t(v))) continue;
        const LocalFrame f = m_.frame(int32_t(v));
        bool seen = false;
        if (!f.degenerate) pull_[v] = sight_.pull(m_.x_mm[v], f.N, t, range, seen), seen_[v] = seen;
      }
    });
  }

  /// Faces that are to be opened: most of their vertices, or their centre, have left the surface.
  std::vector<uint8_t> blind_faces() const {
    std::vector<uint8_t> lost(m_.nbr.size(), 0), out(m_.face_edge.size(), 0);
    for (int32_t v = 0; v < m_.slots(); ++v)
      lost[size_t(v)] = m_.alive(v) && sight_.lost(m_.x_mm[size_t(v)], seen_[size_t(v)]);
    for (int32_t f = 0; f < m_.face_slots(); ++f) {
      if (!m_.alive_face(f) || is_end(m_.kind(f))) continue;
      int n = 0;
      m_.around(f, [&](int32_t h) { n += lost[size_t(h / 3)]; });
      out[size_t(f)] = 2 * n > m_.face_size[size_t(f)] || sight_.lost(face_centre(m_, f), true);
    }
    return out;
  }

  /// The edge of a plane, which is held above the border of its sheet: as strongly as the rim's own curve draws.
  void hold(const ScanHeights& heights, const EndContour& e, double beta) {
    const ScanView& view = heights.view();
    const Vec2 half = view.sheet_mm();
    for (int32_t v : e.rim) {
      const Vec3 q = view.local(m_.x_mm[size_t(v)]);
      Vec3 to(std::clamp(q.x(), -half.x(), half.x()), std::clamp(q.y(), -half.y(), half.y()), heights.at(q));
      const Vec2 inside = half - to.head<2>().cwiseAbs();
      const int k = inside.x() < inside.y() ? 0 : 1;
      to[k] = std::copysign(half[k], to[k]);
      pull_[size_t(v)] = 0.5 / beta * (view.place(to) - m_.x_mm[size_t(v)]);
    }
  }

  /// Rims of a plane are drawn to the edge of the scan, others go on to points that the mesh has not reached; small
  /// ones are left alone: a few points would draw them together.
  void to_scan_edge(const EndContour& e) {
    double around = 0;
    for (size_t i = 0; i < e.rim.size(); ++i)
      around += (m_.x_mm[size_t(e.rim[i])] - m_.x_mm[size_t(e.rim[(i + 1) % e.rim.size()])]).norm();
    if (around < kSmallRim * sight_.voxel()) return;
    const size_t n = e.rim.size();
    std::vector<Vec3> move(n);
    std::vector<uint8_t> known(n, 0);
    for (size_t i = 0; i < n; ++i) {
      const int32_t v = e.rim[i];
      const Vec3& x = m_.x_mm[size_t(v)];
      move[i] = sight_.to_edge(x);
      if (move[i] == Vec3::Zero())
        if (const LocalFrame f = m_.frame(v); !f.degenerate) {
          move[i] = sight_.onwards(
              x, f.N,
              f.N.cross(m_.x_mm[size_t(e.rim[(i + 1) % n])] - m_.x_mm[size_t(e.rim[(i + n - 1) % n])]).normalized(),
              left_);
          onwards_ |= move[i] != Vec3::Zero();
        }
      known[i] = move[i] != Vec3::Zero();
    }
    even(e, move, known, [&](size_t v, const Vec3& way) { pull_[v] = way; });
  }

  /// The places of a scan that the mesh does not reach yet.
  void look_for_more() {
    const std::vector<Vec3>& places = sight_.surface();
    const FanTriangles fan = fan_triangles(m_);
    const Bvh bvh(fan.X_mm, fan.tri);
    std::vector<uint8_t> reached(places.size());
    workers_.parallel_for(places.size(), 256, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) reached[i] = bvh.closest(places[i], sight_.voxel()).distance_mm < sight_.voxel();
    });
    left_.clear();
    for (size_t i = 0; i < places.size(); ++i)
      if (!reached[i]) left_.push_back(int32_t(i));
    onwards_ = false;
  }

  /// Rims at the border of the data are drawn to it, those of other
  /// openings to the crest of the surface there (fit_rims.cpp).
  /// Where they belong is found anew when `find` is set.
  void to_border(double beta, bool find) {
    if (find) rim_to_.assign(m_.nbr.size(), kNowhere);
    const std::vector<EndContour> ends = end_contours(m_);
    if (find && !ends.empty() && !sight_.knows_air() && !framed_) look_for_more();
    for (const EndContour& e : ends) {
      if (!sight_.knows_air()) {
        if (framed_)
          hold(*sight_.heights(), e, beta);
        else
          to_scan_edge(e);
        continue;
      }
      if (!opening_) {  // what the mesh began with is held at the border, as strongly as the rim's own curve draws
        for (int32_t v : e.rim) {
          Vec3 outward, &pull = pull_[size_t(v)];
          double way = 0;
          if (sight_.border(m_.x_mm[size_t(v)], 6 * sight_.voxel(), outward, way) >= 0)
            pull += (0.5 / beta * way - outward.dot(pull)) * outward;
        }
        continue;
      }
      if (find) find_rim(e);
      for (int32_t v : e.rim)
        if (const Vec3& to = rim_to_[size_t(v)]; to.x() != kNowhere.x()) pull_[size_t(v)] = to - m_.x_mm[size_t(v)];
    }
  }

  void find_rim(const EndContour& e) {
    const size_t n = e.rim.size();
    std::vector<Vec3> outward(n, Vec3::Zero()), move(n, Vec3::Zero());
    std::vector<uint8_t> known(n, 0);
    for (size_t i = 0; i < n; ++i) {
      double way = 0;
      sight_.border(m_.x_mm[size_t(e.rim[i])], 2 * sight_.voxel(), outward[i], way);
    }
    for (size_t i = 0; i < n; ++i) {
      const int32_t v = e.rim[i];
      const Vec3 &x = m_.x_mm[size_t(v)],
                 along = m_.x_mm[size_t(e.rim[(i + 1) % n])] - m_.x_mm[size_t(e.rim[(i + n - 1) % n])];
      Vec3 N = Vec3::Zero(), to;
      for (const int32_t u : {v, m_.nbr[size_t(v)][0], m_.nbr[size_t(v)][1], m_.nbr[size_t(v)][2]})
        if (const LocalFrame f = m_.frame(u); !f.degenerate) N += f.N;
      known[i] = along.norm() > 0 && N.norm() > 0 && sight_.rim(x, along.normalized(), N.normalized(), outward[i], to);
      if (known[i]) move[i] = to - x;
    }
    even(e, move, known, [&](size_t v, const Vec3& way) { rim_to_[v] = m_.x_mm[v] + way; });
  }

  /// Evenly along a rim: one vertex does not know its way better than its neighbours.
  template <class Visit>
  static void even(const EndContour& e, const std::vector<Vec3>& move, const std::vector<uint8_t>& known,
                   Visit&& visit) {
    const size_t n = e.rim.size();
    for (size_t i = 0; i < n; ++i) {
      const size_t a = (i + n - 1) % n, b = (i + 1) % n;
      const double w = known[a] + 2 * known[i] + known[b];
      if (known[i] || (known[a] && known[b]))
        visit(size_t(e.rim[i]), Vec3((known[a] * move[a] + 2 * known[i] * move[i] + known[b] * move[b]) / w));
    }
  }

  void measure() {
    look(1, range(1));
    std::vector<double> d;
    for (int32_t v = 0; v < m_.slots(); ++v) {
      if (!m_.alive(v)) continue;
      const Vec3& x = m_.x_mm[size_t(v)];
      if (seen_[size_t(v)])
        d.push_back(sight_.distance(x, pull_[size_t(v)]));
      else if (const double beside = sight_.nearest(x, 2 * sight_.voxel()); std::isfinite(beside))
        d.push_back(beside);
      else if (sight_.on_wall(x))
        ++r_.on_walls;
    }
    const int32_t elsewhere = m_.vertices() - r_.on_walls;
    r_.found = elsewhere > 0 ? double(d.size()) / elsewhere : 0;
    std::sort(d.begin(), d.end());
    for (double x : d) r_.rms_mm += x * x / double(d.size());
    r_.rms_mm = std::sqrt(r_.rms_mm);
    if (!d.empty()) r_.p95_mm = d[d.size() * 95 / 100], r_.max_mm = d.back();
    // The other way: from the surface's own places to the mesh, its faces included.
    const std::vector<Vec3>& places = sight_.surface();
    const FanTriangles fan = fan_triangles(m_);
    if (places.empty() || fan.tri.empty()) return;
    const Bvh bvh(fan.X_mm, fan.tri);
    const size_t every = std::max<size_t>(1, places.size() / 20000), n = (places.size() + every - 1) / every;
    std::vector<double> away(n);
    workers_.parallel_for(n, 256, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) away[i] = bvh.closest(places[i * every], 2 * sight_.voxel()).distance_mm;
    });
    std::sort(away.begin(), away.end());
    const size_t reached = size_t(std::lower_bound(away.begin(), away.end(), 2 * sight_.voxel()) - away.begin());
    r_.reached = double(reached) / double(n);
    for (size_t i = 0; i < reached; ++i) r_.surface_rms_mm += away[i] * away[i] / double(reached);
    r_.surface_rms_mm = std::sqrt(r_.surface_rms_mm);
    if (reached > 0) r_.surface_p95_mm = away[reached * 95 / 100 < reached ? reached * 95 / 100 : reached - 1];
  }

  Mesh& m_;
  const Sight& sight_;
  Vec3 low_, high_;
  const FitSettings& s_;
  Workers& workers_;
  Motion motion_;
  Topology topology_;
  bool opening_ = false;  // rims are made, and go where they belong
  bool onwards_ = false;  // some rim has found more of a scan
  std::vector<int32_t> left_;
  bool framed_;  // a plane's edge is held, until the apron is opened
  FitReport r_;
  std::vector<Vec3> pull_, rim_to_;
  std::vector<uint8_t> seen_, still_;
};

void check_settings(const Mesh& m, const FitSettings& s) {
  if (!std::isfinite(s.iso)) throw InputError("", 0, "the isovalue must be a finite number");
  for (double l : {s.range_mm, s.edge_mm, s.still_mm})
    if (!std::isfinite(l) || l <= 0)
      throw InputError("", 0, "range, edge and stillness of a fit must be finite lengths above 0 mm");
  if (s.stages < 1 || s.stages > 100 || s.iterations < 1 || s.iterations > 100000)
    throw InputError("", 0, "a fit has 1 to 100 stages of 1 to 100000 iterations");
  if (m.vertices() == 0) throw InputError("", 0, "a fit needs a mesh and a volume");
}

}  // namespace

Mesh start_mesh(Start kind, const Vec3& low, const Vec3& high, int axis) {
  if (!low.allFinite() || !high.allFinite() || !((high - low).minCoeff() >= 0) || !((high - low).norm() > 0))
    throw InputError("", 0, "the box around the object is empty");
  const Vec3 middle = 0.5 * (low + high), half = (0.5 * (high - low)).cwiseMax(0.02 * (high - low).norm());
  Mesh m;
  if (kind == Start::sphere) {
    m = make_sphere_of_faces({0, 0, 0}, 1, 1002);
    for (Vec3& x : m.x_mm) x = middle + 1.25 * half.cwiseProduct(x);
  } else if (kind == Start::cylinder) {
    const Vec3 side(half[(axis + 1) % 3], half[(axis + 2) % 3], half[axis]);
    const double length = 2 * side.z() / std::sqrt(side.x() * side.y());
    m = make_cylinder(1, length, 40);
    for (Vec3& x : m.x_mm) {
      const Vec3 q(1.2 * side.x() * x.x(), 1.2 * side.y() * x.y(), 2 * side.z() * (x.z() / length - 0.5));
      x[(axis + 1) % 3] = middle[(axis + 1) % 3] + q.x(), x[(axis + 2) % 3] = middle[(axis + 2) % 3] + q.y(),
                     x[axis] = middle[axis] + q.z();
    }
  } else {
    const double edge = std::sqrt(half.x() * half.z() * 4 / 2000 /
                                  1.3);  // about 2000 vertices: 4 / (3 sqrt 3) edge^-2 of them per area
    m = make_plane(2 * half.x(), 2 * half.z(), edge);
    for (Vec3& x : m.x_mm)
      x = Vec3(low.x() + x.x(), low.y() - 0.1 * half.y(), low.z() + x.y());  // (x, y) -> (x, z): the normal looks to -y
  }
  m.before_mm = m.x_mm;
  return m;
}

FitReport fit(Mesh& m, const Prepared& p, const FitSettings& s, Workers& w) {
  check_settings(m, s);
  if (p.volume.value.empty()) throw InputError("", 0, "a fit needs a mesh and a volume");
  const VolumeSight sight(p);
  const FitReport report = Fitter(m, sight, p.low_mm, p.high_mm, s, w).run();
  m.axes = simplex::Axes::left_posterior_superior;  // as the places of a volume (volume.h)
  return report;
}

FitReport fit(Mesh& m, const Volume& v, const FitSettings& s, Workers& w) {
  check_settings(m, s);
  if (v.value.empty()) throw InputError("", 0, "a fit needs a mesh and a volume");
  PrepareSettings q;
  q.iso = s.iso, q.sigma_voxels = 0;
  q.seal_mm = 2 * std::min({v.step_mm.col(0).norm(), v.step_mm.col(1).norm(), v.step_mm.col(2).norm()});
  const Prepared p = prepare(v, q, w);
  return fit(m, p, s, w);
}

FitReport fit(Mesh& m, const std::vector<Vec3>& points, const FitSettings& s, Workers& w, const ScanView* plane,
              const std::vector<Vec3>& looks) {
  check_settings(m, s);
  if (points.size() < 10) throw InputError("", 0, "a range scan of at least 10 points was expected");
  if (!looks.empty() && looks.size() != points.size())
    throw InputError("", 0,
                     "a scan of " + std::to_string(points.size()) + " points with " + std::to_string(looks.size()) +
                         " directions; one for each, or none, was expected");
  Vec3 low = points.front(), high = low;
  for (const Vec3& x : points) {
    if (!x.allFinite()) throw InputError("", 0, "a point of the scan is not at a finite place");
    low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
  if (!((high - low).norm() > 0)) throw InputError("", 0, "all points of the scan are the same");
  const PointSight sight(points, plane, looks);
  return Fitter(m, sight, low, high, s, w).run();
}

}  // namespace limberg
