#include "sim/imaging/fit.h"

#include <algorithm>
#include <cmath>

#include "sim/error.h"
#include "sim/simplex/adapt.h"
#include "sim/simplex/contour.h"
#include "sim/simplex/motion.h"

namespace limberg {
namespace {

using namespace simplex;

class Fitter {
 public:
  Fitter(Mesh& m, const Volume& v, const FitSettings& s, Workers& w) : m_(m), sampler_(v), s_(s), workers_(w), motion_(w) {
    voxel_ = std::min({v.step_mm.col(0).norm(), v.step_mm.col(1).norm(), v.step_mm.col(2).norm()});
  }

  FitReport run() {
    FitReport r;
    double longest = 0;  // mean edge of the mesh as it is given
    for (int32_t v = 0; v < m_.slots(); ++v)
      if (m_.alive(v)) longest += (m_.x_mm[size_t(v)] - m_.x_mm[size_t(m_.nbr[size_t(v)][0])]).norm() / m_.vertices();
    for (int stage = 0; stage < s_.stages; ++stage) {
      const double t = s_.stages > 1 ? double(stage) / (s_.stages - 1) : 1;
      Law law;
      ZoneLaw& z = law.zone[0];
      z.constraint = Constraint::angle, z.alpha = 0.5;
      z.rigidity = std::max(1, int(std::lround(8 * std::pow(1. / 8, t))));
      z.beta = 0.05 * std::pow(10, t);
      law.external_stiffness = 1, law.max_step_mm = 0.25 * s_.range_mm;
      if (const Admission a = motion_.set_law(law); !a) throw InputError("", 0, a.refused);
      const double range = std::max(2 * voxel_, s_.range_mm * std::pow(2 * voxel_ / s_.range_mm, t));
      int still = 0;
      double move = 0;
      for (int i = 0; i < s_.iterations && still < 10; ++i) {
        look(range);
        move = motion_.step(m_, {pull_, {}}).max_move_mm;
        still = move < s_.still_mm ? still + 1 : 0;
        ++r.iterations, r.vertex_iterations += m_.vertices();
      }
      if (s_.progress) s_.progress(stage, m_.vertices(), move);
      if (stage + 1 < s_.stages) {
        AdaptSettings a;
        a.edge_mm = std::max(s_.edge_mm, longest * std::pow(s_.edge_mm / longest, double(stage + 1) / std::max(1, s_.stages - 2)));
        a.chord_mm = s_.chord_mm, a.passes = 2, a.seed = uint64_t(stage) + 1;
        Delta d;
        adapt(m_, a, d);
        compact(m_, true);
      }
    }
    measure(r);
    if (s_.open_ends) open(r);
    r.vertices = m_.vertices();
    return r;
  }

 private:
  /// Signed way along the normal to the nearest place where the volume falls through iso outwards; false: none within range.
  /// Outside the volume nothing is known: no edge there, nor across its border.
  bool edge(const Vec3& x, const Vec3& n, double range, double& at) const {
    const double h = 0.5 * voxel_;
    const auto known = [&](const Vec3& p, double& f) {
      if (!sampler_.inside(p)) return false;
      f = sampler_.value(p) - s_.iso;
      return true;
    };
    double out = 0, in = 0, f = 0;
    bool out_known = known(x, out), in_known = out_known;
    in = out;
    for (double t = 0; t < range; t += h) {
      bool k = known(x + (t + h) * n, f);
      if (k && out_known && out >= 0 && f < 0) {
        at = t + h * out / (out - f);
        return true;
      }
      out = f, out_known = k;
      k = known(x - (t + h) * n, f);
      if (k && in_known && f >= 0 && in < 0) {
        at = -(t + h * in / (in - f));
        return true;
      }
      in = f, in_known = k;
    }
    return false;
  }

  void look(double range) {
    pull_.assign(m_.nbr.size(), Vec3::Zero());
    seen_.assign(m_.nbr.size(), 0);
    workers_.parallel_for(m_.nbr.size(), 256, [&](size_t b, size_t e) {
      for (size_t v = b; v < e; ++v) {
        if (!m_.alive(int32_t(v))) continue;
        const LocalFrame f = m_.frame(int32_t(v));
        double t = 0;
        if (!f.degenerate && edge(m_.x_mm[v], f.N, range, t)) pull_[v] = t * f.N, seen_[v] = 1;
      }
    });
  }

  void measure(FitReport& r) {
    look(2 * voxel_);
    std::vector<double> d;
    for (int32_t v = 0; v < m_.slots(); ++v) {
      if (!m_.alive(v) || !seen_[size_t(v)]) continue;
      const double g = sampler_.gradient(m_.x_mm[size_t(v)]).norm(), f = std::abs(sampler_.value(m_.x_mm[size_t(v)]) - s_.iso);
      // Where the volume is flat the first order says nothing: then the way along the normal.
      d.push_back(std::min(g > 0 ? f / g : 1e300, pull_[size_t(v)].norm()));
    }
    r.rms_mm = r.p95_mm = r.max_mm = 0;
    r.found = m_.vertices() > 0 ? double(d.size()) / m_.vertices() : 0;
    if (d.empty()) return;
    std::sort(d.begin(), d.end());
    for (double x : d) r.rms_mm += x * x / double(d.size());
    r.rms_mm = std::sqrt(r.rms_mm), r.p95_mm = d[d.size() * 95 / 100], r.max_mm = d.back();
  }

  void open(FitReport& r) {
    // Connected groups of faces none of whose vertices has found anything.
    std::vector<uint8_t> blind(m_.face_edge.size(), 0);
    for (int32_t f = 0; f < m_.face_slots(); ++f) {
      if (!m_.alive_face(f) || is_end(m_.kind(f))) continue;
      blind[size_t(f)] = 1;
      m_.around(f, [&](int32_t h) { blind[size_t(f)] &= !seen_[size_t(m_.from(h))]; });
    }
    std::vector<std::vector<int32_t>> groups;
    for (int32_t f = 0; f < m_.face_slots(); ++f) {
      if (blind[size_t(f)] != 1) continue;
      std::vector<int32_t> g{f};
      blind[size_t(f)] = 2;
      for (size_t i = 0; i < g.size(); ++i)
        m_.around(g[i], [&](int32_t h) {
          const int32_t q = m_.face(m_.twin(h));
          if (blind[size_t(q)] == 1) blind[size_t(q)] = 2, g.push_back(q);
        });
      if (g.size() >= 3) groups.push_back(std::move(g));
    }
    for (const auto& g : groups) {
      Delta d;
      bool whole = true;
      for (int32_t f : g) whole &= m_.alive_face(f);
      if (whole && open_hole(m_, g, d)) ++r.holes;
    }
    if (r.holes == 0) return;
    compact(m_);
    measure(r);  // of what is left
  }

  Mesh& m_;
  VolumeSampler sampler_;
  const FitSettings& s_;
  Workers& workers_;
  Motion motion_;
  double voxel_ = 1;
  std::vector<Vec3> pull_;
  std::vector<uint8_t> seen_;
};

}  // namespace

FitReport fit(Mesh& m, const Volume& v, const FitSettings& s, Workers& w) {
  if (!std::isfinite(s.iso)) throw InputError("", 0, "the isovalue must be a finite number");
  for (double l : {s.range_mm, s.edge_mm, s.still_mm})
    if (!std::isfinite(l) || l <= 0) throw InputError("", 0, "range, edge and stillness of a fit must be finite lengths above 0 mm");
  if (s.stages < 1 || s.stages > 100 || s.iterations < 1 || s.iterations > 100000) throw InputError("", 0, "a fit has 1 to 100 stages of 1 to 100000 iterations");
  if (v.value.empty() || m.vertices() == 0) throw InputError("", 0, "a fit needs a mesh and a volume");
  return Fitter(m, v, s, w).run();
}

}  // namespace limberg
