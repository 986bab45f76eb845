#include "sim/skull/simplex/motion.h"

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/skull/simplex/contour.h"

namespace limberg::simplex {
namespace {

constexpr size_t kGrain = 2048;  // a multiple of the kernel's lanes

const double* raw(const std::vector<Vec3>& x) { return x.empty() ? nullptr : x[0].data(); }
double* raw(std::vector<Vec3>& x) { return x.empty() ? nullptr : x[0].data(); }

}  // namespace

Admission Motion::set_law(const Law& law, Excess excess) {
  Admission a = admit(law, excess);
  if (!a) return a;
  law_ = a.law, have_law_ = true, rebuild_ = true, iteration_ = 0;
  zone_.clear(), angle_ = curvature_ = shape_ = wide_ = false;
  for (const ZoneLaw& z : law_.zone) {
    zone_.push_back({int32_t(z.constraint), z.rigidity, z.fixed ? -1 : z.alpha, z.beta});
    angle_ |= z.constraint == Constraint::angle, curvature_ |= z.constraint == Constraint::curvature;
    shape_ |= z.constraint == Constraint::shape;
    wide_ |= z.rigidity > 1 && (z.constraint == Constraint::angle || z.constraint == Constraint::curvature);
  }
  return a;
}

void Motion::prepare(const Mesh& m) {
  if (!have_law_) set_law(Law{});
  if (!rebuild_ && version_ == m.version && sums_.size() == (m.nbr.size() + kGrain - 1) / kGrain) return;
  rebuild_ = false, version_ = m.version;
  const size_t n = m.nbr.size();
  sums_.assign((n + kGrain - 1) / kGrain, {});
  if (angle_) phi_.resize(n);
  if (curvature_ || law_.metric_gain > 0) H_.resize(n);
  if (shape_) {
    shape_of_.resize(n);
    for (size_t v = 0; v < n; ++v) {
      const VertexShape& s = m.shape[v];
      shape_of_[v] = {s.e1,
                      s.e2,
                      elementary::sin(s.phi),
                      elementary::cos(s.phi),
                      s.height,
                      s.branch == ShapeBranch::near  ? 1.
                      : s.branch == ShapeBranch::far ? -1.
                                                     : 0.};
    }
  }
  near_first_.clear(), near_.clear();
  if (wide_) neighbourhoods(m);
  rim_.clear();
  for (const EndContour& e : end_contours(m)) {
    const int32_t first = int32_t(rim_.size()), size = int32_t(e.rim.size());
    for (int32_t i = 0; i < size; ++i) {
      const int32_t v = e.rim[size_t(i)];
      const int32_t before = e.rim[size_t((i + size - 1) % size)], after = e.rim[size_t((i + 1) % size)];
      const Row& r = m.nbr[size_t(v)];
      const int32_t spoke = r[0] != before && r[0] != after ? r[0] : r[1] != before && r[1] != after ? r[1] : r[2];
      rim_.push_back({v, before, after, spoke, first, size, i});
    }
  }
  offset_.resize(rim_.size()), rim_next_.resize(rim_.size());
}

void Motion::neighbourhoods(const Mesh& m) {
  const int32_t n = m.slots();
  std::vector<int32_t> seen(size_t(n), -1);
  near_first_.reserve(size_t(n) + 1);
  near_first_.push_back(0);
  for (int32_t v = 0; v < n; ++v) {
    if (m.alive(v)) {
      const KernelZone& z = zone_of(m, v);
      const bool needed = z.rigidity > 1 && (z.constraint == int32_t(Constraint::angle) ||
                                             z.constraint == int32_t(Constraint::curvature));
      size_t at = near_.size();
      seen[size_t(v)] = v;
      near_.push_back(v);
      for (int s = 0; needed && s < z.rigidity; ++s) {
        const size_t last = near_.size();
        for (; at < last; ++at)
          for (int32_t u : m.nbr[size_t(near_[at])])
            if (seen[size_t(u)] != v) seen[size_t(u)] = v, near_.push_back(u);
      }
    }
    near_first_.push_back(near_.size());
  }
}

const KernelZone& Motion::zone_of(const Mesh& m, int32_t v) const {
  return zone_[std::min(size_t(m.zone[size_t(v)]), zone_.size() - 1)];
}

KernelView Motion::view(const Mesh& m) {
  KernelView v;
  v.x = raw(m.x_mm);
  v.nbr = m.nbr.empty() ? nullptr : m.nbr[0].data();
  v.zone = m.zone.data(), v.flags = m.flags.data();
  v.metric = m.metric.empty() ? nullptr : m.metric[0].data();
  v.shape = shape_of_.data(), v.law = zone_.data(), v.zones = int32_t(zone_.size());
  v.near_first = near_first_.data(), v.near = near_.data();
  v.large = m.nbr.size() > 40000;
  v.keep = 1 - law_.gamma, v.max_step_mm = std::min(law_.max_step_mm, 1e100);  // (its square is finite)
  return v;
}

void Motion::curvature_pass(const Mesh& m, KernelView& v) {
  if (!angle_ && !curvature_) return;
  workers_.parallel_for(m.nbr.size(), kGrain, [&](size_t b, size_t e) {
    kernel_curvature(v, b, e, angle_ ? phi_.data() : nullptr, curvature_ ? H_.data() : nullptr);
  });
  v.phi = phi_.data(), v.H = H_.data();
}

void Motion::rim_offsets(const Mesh& m) {
  for (size_t i = 0; i < rim_.size(); ++i) {
    const RimVertex& r = rim_[i];
    const Vec3 &A = m.x_mm[size_t(r.before)], &B = m.x_mm[size_t(r.after)], &P = m.x_mm[size_t(r.v)];
    RimOffset& o = offset_[i];
    o = RimOffset{};
    o.chord = (B - A).norm();
    if (!(o.chord > 0)) continue;
    const Vec3 t = (B - A) / o.chord;
    // The surface lies between before, spoke and after, counter-clockwise; its normal also where the rim is dented.
    const Vec3 spoke = m.x_mm[size_t(r.spoke)] - P;
    Vec3 n = (A - P).cross(spoke) + spoke.cross(B - P);
    n -= n.dot(t) * t;
    if (!(n.norm() > 0)) continue;
    o.normal = n.normalized(), o.side = o.normal.cross(t);
    o.along_normal = (P - A).dot(o.normal) / o.chord, o.along_side = (P - A).dot(o.side) / o.chord;
  }
}

Vec3 Motion::rim_force(const Mesh& m, size_t i) const {
  const RimVertex& r = rim_[i];
  const RimOffset& o = offset_[i];
  const KernelZone& z = zone_of(m, r.v);
  const Vec3 &A = m.x_mm[size_t(r.before)], &B = m.x_mm[size_t(r.after)];
  double normal = 0, side = 0;
  if (z.constraint == int32_t(Constraint::position)) {
    normal = o.along_normal, side = o.along_side;
  } else if (z.constraint != int32_t(Constraint::tangent)) {
    const int32_t reach = std::min(z.rigidity, (r.size - 1) / 2);
    for (int32_t j = -reach; j <= reach; ++j) {
      const RimOffset& q = offset_[size_t(r.first + (r.at + j + r.size) % r.size)];
      normal += q.along_normal, side += q.along_side;
    }
    normal /= 2 * reach + 1, side /= 2 * reach + 1;
  }
  return 0.5 * (A + B) + o.chord * (normal * o.normal + side * o.side) - m.x_mm[size_t(r.v)];
}

double Motion::push(const Mesh& m, std::span<const Repulsor> repulsor) {
  double all = 0;
  for (const Repulsor& r : repulsor) {
    if (!r.from_mm.allFinite() || !r.to_mm.allFinite() || !std::isfinite(r.radius_mm) || !std::isfinite(r.beta) ||
        r.radius_mm < 0 || r.beta < 0)
      throw InputError("", 0, "a repulsor needs a finite place, and a radius and a strength of 0 or more");
    all += r.beta;
  }
  const double room = stiffness_left(law_), scale = all > room ? room / all : 1;
  push_.resize(m.nbr.size());
  workers_.parallel_for(m.nbr.size(), kGrain, [&](size_t b, size_t e) {
    for (size_t v = b; v < e; ++v) {
      Vec3 f = Vec3::Zero();
      for (const Repulsor& r : repulsor) {
        const Vec3 way = r.to_mm - r.from_mm, p = m.x_mm[v] - r.from_mm;
        const double l = way.squaredNorm(), t = l > 0 ? std::clamp(p.dot(way) / l, 0., 1.) : 0;
        const Vec3 out = p - t * way;
        const double d = out.norm();
        if (d >= r.radius_mm || !m.alive(int32_t(v))) continue;
        // At the very centre outwards is where the surface looks.
        const Vec3 u = d > 1e-9 * r.radius_mm ? Vec3(out / d) : m.frame(int32_t(v)).N;
        f += scale * r.beta * (r.radius_mm - d) * u;
      }
      push_[v] = f;
    }
  });
  return scale;
}

StepReport Motion::step(Mesh& m, const External& external) {
  prepare(m);
  const size_t n = m.nbr.size();
  if (!external.force_mm.empty() && external.force_mm.size() != n)
    throw InputError("", 0,
                     "there are " + std::to_string(external.force_mm.size()) + " external forces for " +
                         std::to_string(n) + " vertices");
  if (law_.metric_gain > 0 && iteration_ % law_.metric_every == 0) adapt_metric(m, law_.metric_gain);
  ++iteration_;
  StepReport report;
  KernelView v = view(m);
  curvature_pass(m, v);
  if (!external.force_mm.empty()) v.ext = external.force_mm[0].data();
  if (!external.repulsor.empty()) {
    report.repulsion = push(m, external.repulsor);
    v.push = raw(push_);
  }
  // Rims first: they need the places that the kernel overwrites.
  rim_offsets(m);
  std::vector<uint8_t> rim_moves(rim_.size(), 0);
  for (size_t i = 0; i < rim_.size(); ++i) {
    const RimVertex& r = rim_[i];
    const KernelZone& z = zone_of(m, r.v);
    const size_t p = size_t(r.v);
    if (z.alpha < 0 || (m.flags[p] & kLocked) || z.constraint == int32_t(Constraint::shape)) continue;
    Vec3 d = (1 - law_.gamma) * (m.x_mm[p] - m.before_mm[p]) + z.alpha * rim_force(m, i);
    if (v.ext) d += z.beta * external.force_mm[p];
    if (v.push) d += push_[p];
    if (const double l = d.norm(); l > v.max_step_mm) d *= v.max_step_mm / l;
    rim_next_[i] = m.x_mm[p] + d, rim_moves[i] = 1;
  }
  double* next = raw(m.before_mm);
  workers_.parallel_for(n, kGrain, [&](size_t b, size_t e) { sums_[b / kGrain] = kernel_step(v, b, e, next); });
  KernelSums all;
  for (const KernelSums& s : sums_) all.sum_move2 += s.sum_move2, all.max_move2 = std::max(all.max_move2, s.max_move2);
  for (size_t i = 0; i < rim_.size(); ++i)
    if (rim_moves[i]) m.before_mm[size_t(rim_[i].v)] = rim_next_[i];
  std::swap(m.x_mm, m.before_mm);
  report.max_move_mm = std::sqrt(all.max_move2);
  report.rms_move_mm = m.vertices() > 0 ? std::sqrt(all.sum_move2 / m.vertices()) : 0;
  return report;
}

void Motion::internal_force(const Mesh& m, std::vector<Vec3>& force) {
  prepare(m);
  KernelView v = view(m);
  curvature_pass(m, v);
  force.assign(m.nbr.size(), Vec3::Zero());
  workers_.parallel_for(m.nbr.size(), kGrain, [&](size_t b, size_t e) { kernel_force(v, b, e, raw(force)); });
  rim_offsets(m);
  for (size_t i = 0; i < rim_.size(); ++i)
    if (zone_of(m, rim_[i].v).constraint != int32_t(Constraint::shape)) force[size_t(rim_[i].v)] = rim_force(m, i);
  for (int32_t p = 0; p < m.slots(); ++p)
    if (!m.alive(p) || (m.flags[size_t(p)] & kLocked) || zone_of(m, p).alpha < 0) force[size_t(p)].setZero();
}

double Motion::rms_force_mm(const Mesh& m) {
  std::vector<Vec3> f;
  internal_force(m, f);
  double sum = 0;
  for (const Vec3& a : f) sum += a.squaredNorm();
  return m.vertices() > 0 ? std::sqrt(sum / m.vertices()) : 0;
}

double Motion::measure_lambda(const Mesh& mesh, int iterations) {
  Mesh m = mesh;
  const size_t n = m.nbr.size();
  double size = 0;
  for (const Vec3& x : m.x_mm) size = std::max(size, x.norm());
  std::vector<Vec3> w(n), f, g;
  uint64_t s = 1;
  for (Vec3& a : w)
    for (int k = 0; k < 3; ++k)
      s = s * 6364136223846793005ull + 1442695040888963407ull, a[k] = double(s >> 11) * 0x1p-53 - 0.5;
  double lambda = 0;
  for (int it = 0; it < iterations; ++it) {
    double norm = 0;
    for (const Vec3& a : w) norm += a.squaredNorm();
    norm = std::sqrt(norm);
    if (!(norm > 0)) return 0;
    const double h = 1e-6 * size;
    for (size_t i = 0; i < n; ++i) w[i] /= norm, m.x_mm[i] = mesh.x_mm[i] + h * w[i];
    internal_force(m, f);
    for (size_t i = 0; i < n; ++i) m.x_mm[i] = mesh.x_mm[i] - h * w[i];
    internal_force(m, g);
    lambda = 0;
    for (size_t i = 0; i < n; ++i) {
      const Vec3 a = (g[i] - f[i]) / (2 * h);
      lambda += a.dot(w[i]);
      w[i] = a;
    }
  }
  return lambda;
}

void Motion::mean_curvature(const Mesh& m, std::vector<double>& H) {
  prepare(m);
  H.resize(m.nbr.size());
  const KernelView v = view(m);
  workers_.parallel_for(m.nbr.size(), kGrain,
                        [&](size_t b, size_t e) { kernel_curvature(v, b, e, nullptr, H.data()); });
}

void Motion::adapt_metric(Mesh& m, double gain) {
  mean_curvature(m, H_);
  constexpr double kLeast = 0.05;
  workers_.parallel_for(m.nbr.size(), kGrain, [&](size_t b, size_t e) {
    for (size_t v = b; v < e; ++v) {
      if (!m.alive(int32_t(v))) continue;
      double h[3], w[3];
      for (size_t k = 0; k < 3; ++k) h[k] = std::abs(H_[size_t(m.nbr[v][k])]);
      const double mean = (h[0] + h[1] + h[2]) / 3;
      auto& e12 = m.metric[v];
      const double now[3] = {e12[0], e12[1], 1 - e12[0] - e12[1]};
      double sum = 0;
      for (size_t k = 0; k < 3; ++k) {
        const double wanted = 1. / 3 + (mean > 0 ? gain * (h[k] - mean) / mean : 0);
        w[k] = std::max(kLeast, now[k] + 0.5 * (wanted - now[k]));
        sum += w[k];
      }
      e12 = {w[0] / sum, w[1] / sum};
    }
  });
}

}  // namespace limberg::simplex
