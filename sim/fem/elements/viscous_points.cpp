#include "sim/fem/elements/viscous_points.h"

#include <Eigen/LU>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/fem/materials/isotropic.h"

namespace limberg::fem {
namespace {

constexpr double kLeastJ = 0.2;  // below it ln J goes on as a parabola, and no stress of shape is remembered

void put(float* to, const Mat3& S) {
  const double v[6] = {S(0, 0), S(1, 1), S(2, 2), S(0, 1), S(1, 2), S(2, 0)};
  for (int i = 0; i < 6; ++i) to[i] = float(v[i]);
}
Mat3 get(const float* v) {
  Mat3 S;
  S << double(v[0]), double(v[3]), double(v[5]), double(v[3]), double(v[1]), double(v[4]), double(v[5]), double(v[4]),
      double(v[2]);
  return S;
}
/// L and L' at J. Where the layer's own pressure s is negative a straight line keeps the energy bounded.
std::pair<double, double> log_volume(double J, double s) {
  if (s < 0) return {J - 1, 1};
  if (J >= kLeastJ) return {elementary::log(J), 1 / J};
  const double x = (J - kLeastJ) / kLeastJ;
  return {elementary::log(kLeastJ) + x - 0.5 * x * x, (1 - x) / kLeastJ};
}

}  // namespace

ViscousPoints::ViscousPoints(const FemModel& m) : laws_(m.laws) {
  struct Range {
    int32_t first = 0, last = 0, group = 0, groups = 0;
    bool neo_hookean = true;
  };
  std::vector<Range> of_stencil;
  int32_t groups = 0;
  for (const Stencil& s : m.stencils) {
    Range& r = of_stencil.emplace_back();
    r.first = int32_t(points_.size()), r.group = groups;
    for (const ViscousPoint& p : s.viscous) {
      if (p.law < 0 || size_t(p.law) >= laws_.size() || !laws_[size_t(p.law)])
        throw InputError(
            "", 0, "a viscous point names law " + std::to_string(p.law) + "; one of the model's laws was expected");
      Point q;
      q.law = laws_[size_t(p.law)].get(), q.law_index = p.law;
      q.mu_kPa = neo_hookean_modulus_kPa(*q.law);
      q.B = trilinear_gradients(s, p.at, m.cell_mm);
      q.M = p.M;
      q.volume_mm3 = p.volume_mm3;
      q.rest_kPa = q.law->at(p.M).energy_kPa;
      q.term = p.terms;
      r.neo_hookean = r.neo_hookean && q.mu_kPa > 0;
      points_.push_back(std::move(q));
    }
    r.last = int32_t(points_.size());
    if (r.neo_hookean) r.groups = (r.last - r.first + 3) / 4, groups += r.groups;
  }
  if (points_.empty()) return;
  groups_.resize(size_t(groups));
  for (const Range& r : of_stencil)
    for (int32_t i = r.first; i < r.last && r.neo_hookean; ++i) {
      ViscousGroup& g = groups_[size_t(r.group + (i - r.first) / 4)];
      const size_t lane = size_t(i - r.first) % 4;
      for (int a = 0; a < 8; ++a)
        for (int j = 0; j < 3; ++j) g.B[3 * a + j][lane] = points_[size_t(i)].B(a, j);
      g.volume[lane] = points_[size_t(i)].volume_mm3;
    }
  std::vector<std::array<int32_t, 8>> nodes;
  std::vector<ViscousCell> for_kernel;
  place_.assign(m.cells.size(), -1);
  size_t size = 0;
  int32_t held = 0;
  for (size_t c = 0; c < m.cells.size(); ++c) {
    const HexCell& cell = m.cells[c];
    const Range& r = of_stencil[size_t(cell.stencil)];
    if (r.first == r.last) continue;
    place_[c] = int32_t(cells_.size());
    cells_.push_back({cell.node, int32_t(c), r.first, r.last, int32_t(size), r.neo_hookean, double(cell.scale)});
    nodes.push_back(cell.node);
    ViscousCell& k = for_kernel.emplace_back();
    std::copy(cell.node.begin(), cell.node.end(), k.node);
    k.group = r.group, k.groups = r.groups, k.held = held, k.scale = cell.scale;
    held += r.groups;
    for (int32_t i = r.first; i < r.last; ++i) size += state_size(points_[size_t(i)]);
  }
  kernel_cell_.resize(for_kernel.size());
  std::copy(for_kernel.begin(), for_kernel.end(), kernel_cell_.begin());
  held_.resize(28 * size_t(held));
  scatter_ = CellScatter(nodes, m.X_mm.size());
  force_.resize(cells_.size()), sums_.resize(cells_.size());
  state_.assign(size, 0);
  relax(NodeArray(m.X_mm.size()));
  rest_ = memory();
}

ViscousPoints::Mat83 ViscousPoints::gather(const Cell& c, const NodeArray& u) {
  Mat83 U;
  for (int a = 0; a < 8; ++a) {
    const Node4& n = u[size_t(c.node[size_t(a)])];
    U.row(a) << double(n.x), double(n.y), double(n.z);
  }
  return U;
}

ViscousPoints::Shape ViscousPoints::shape_stress(const Point& p, const Mat83& U) {
  const Mat3 D = U.transpose() * p.B, F = p.M + D * p.M;
  Shape r;
  if (!(F.determinant() > kLeastJ)) return r;
  const Mat3 C = F.transpose() * F;
  if (p.mu_kPa > 0) {  // S = mu I
    r.s = p.mu_kPa * C.trace() / 3;
    r.S = p.mu_kPa * Mat3::Identity() - r.s * C.inverse();
  } else {
    const Mat3 inverse = F.inverse(), S = inverse * p.law->at(F).P_kPa;
    r.s = (S * C).trace() / 3;
    r.S = S - r.s * inverse * inverse.transpose();
  }
  r.sound = r.S.allFinite();
  return r;
}

void ViscousPoints::carry(const ViscousPoints& before, const ParentList& parent, const NodeArray& u) {
  if (empty()) return;
  relax(u);
  if (before.empty()) return;
  settle(), before.settle();
  for (const Cell& c : cells_) {
    if (size_t(c.cell) >= parent.size() || parent[size_t(c.cell)] < 0 ||
        size_t(parent[size_t(c.cell)]) >= before.place_.size())
      continue;
    const int32_t old = before.place_[size_t(parent[size_t(c.cell)])];
    if (old < 0) continue;
    const Cell& b = before.cells_[size_t(old)];
    float* to = state_.data() + c.state;
    for (int32_t i = c.first; i < c.last; ++i) {
      const float* from = before.state_.data() + b.state;
      for (int32_t k = b.first; k < b.last; ++k) {
        const Point &p = points_[size_t(i)], &q = before.points_[size_t(k)];
        if (p.law_index == q.law_index && p.term.size() == q.term.size()) std::copy(from, from + state_size(q), to);
        from += state_size(q);
      }
      to += state_size(points_[size_t(i)]);
    }
  }
}

Mat3 ViscousPoints::remembered(const Point& p, const float* state) {
  Mat3 B = -p.G * get(state);
  for (size_t t = 0; t < p.term.size(); ++t) B += p.a[t] * get(state + 7 + 6 * t);
  return B;
}

void ViscousPoints::begin_step(double dt_s) {
  if (empty()) return;
  settle();
  in_step_ = true;
  for (Point& p : points_) {
    p.a.clear(), p.h.clear(), p.G = 0;
    for (const auto& t : p.term) {
      p.a.push_back(elementary::exp(-dt_s / t.time_s));
      p.h.push_back(elementary::exp(-0.5 * dt_s / t.time_s));
      p.G += t.ratio * p.h.back();
    }
  }
  for (size_t c = 0; c < cells_.size(); ++c)
    if (cells_[c].neo_hookean) hold(cells_[c], c);
}

/// What the kernel needs of a cell's points while the step lasts.
void ViscousPoints::hold(const Cell& cell, size_t index) {
  const float* state = state_.data() + cell.state;
  float* to = held_.data() + 28 * size_t(kernel_cell_[index].held);
  for (int32_t i = cell.first; i < cell.last; state += state_size(points_[size_t(i)]), ++i) {
    const Point& p = points_[size_t(i)];
    const Mat3 H = p.M * (p.G * p.mu_kPa * Mat3::Identity() + remembered(p, state)) * p.M.transpose();
    const double v[7] = {H(0, 0), H(1, 1), H(2, 2), H(0, 1), H(1, 2), H(2, 0), p.G * double(state[6])};
    const size_t k = size_t(i - cell.first);
    for (size_t j = 0; j < 7; ++j) to[28 * (k / 4) + 4 * j + k % 4] = float(v[j]);
  }
}

CellSums ViscousPoints::force(const Cell& cell, const NodeArray& u, CellForce& out) const {
  const Mat83 U = gather(cell, u);
  Mat83 f = Mat83::Zero();
  CellSums sums;
  const float* state = state_.data() + cell.state;
  for (int32_t i = cell.first; i < cell.last; state += state_size(points_[size_t(i)]), ++i) {
    const Point& p = points_[size_t(i)];
    const double s = double(state[6]);
    const Mat3 B = remembered(p, state), D = U.transpose() * p.B, grad = Mat3::Identity() + D, dF = D * p.M,
               F = p.M + dF;
    const MaterialLaw::Response r = p.law->at(F);
    const auto [L, L1] = log_volume(grad.determinant(), s);
    // B : C relative to rest, from the change of F: no large numbers are subtracted.
    const Mat3 dC = p.M.transpose() * dF + dF.transpose() * F;
    const double shape = p.G * (r.energy_kPa - p.rest_kPa), memory = 0.5 * B.cwiseProduct(dC).sum(),
                 volume = p.G * s * L;
    sums.energy += p.volume_mm3 * (shape + memory - volume);
    sums.magnitude += p.volume_mm3 * (std::fabs(shape) + std::fabs(memory) + std::fabs(volume));
    const Mat3 P = (p.G * r.P_kPa + F * B) * p.M.transpose() - p.G * s * L1 * cofactor(grad);
    f.noalias() += p.volume_mm3 * p.B * P.transpose();
  }
  out = cell_force(f, cell.scale);
  return {cell.scale * sums.energy, cell.scale * sums.magnitude};
}

CellSums ViscousPoints::add(const NodeArray& u, NodeArray& g, bool measure, const Engine& engine) const {
  if (empty() || !in_step_) return {};
  const ViscousView view{groups_.data(), kernel_cell_.data(), held_.data()};
  engine.workers().parallel_for(cells_.size(), 64, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      size_t to = c;
      while (to < end && cells_[to].neo_hookean) ++to;
      if (to > c) engine.kernels().viscous_cells(view, u.data(), c, to, sums_.data(), force_[0].data());
      if ((c = to) < end) sums_[c] = force(cells_[c], u, force_[c]);
    }
  });
  scatter_.add(force_, g, measure, engine.workers());
  return total(sums_);
}

void ViscousPoints::end_step(const NodeArray& u) {
  if (empty() || !in_step_) return;
  in_step_ = false;
  for (const Cell& c : cells_) {
    const Mat83 U = gather(c, u);
    float* state = state_.data() + c.state;
    for (int32_t i = c.first; i < c.last; state += state_size(points_[size_t(i)]), ++i) {
      const Point& p = points_[size_t(i)];
      const Shape now = shape_stress(p, U);
      const Mat3 change = now.sound ? Mat3(now.S - get(state)) : Mat3(Mat3::Zero());
      for (size_t t = 0; t < p.term.size(); ++t)
        put(state + 7 + 6 * t, p.a[t] * get(state + 7 + 6 * t) + p.term[t].ratio * p.h[t] * change);
      if (now.sound) put(state, now.S), state[6] = float(now.s);
    }
  }
}

void ViscousPoints::relax(const NodeArray& u) {
  if (empty()) return;
  in_step_ = false;
  if (relaxed_at_.size() != u.size()) relaxed_at_.resize(u.size());
  std::copy(u.begin(), u.end(), relaxed_at_.begin());
  owed_ = true;
}

void ViscousPoints::settle() const {
  if (!owed_) return;
  owed_ = false;
  for (const Cell& c : cells_) {
    const Mat83 U = gather(c, relaxed_at_);
    float* state = state_.data() + c.state;
    for (int32_t i = c.first; i < c.last; state += state_size(points_[size_t(i)]), ++i) {
      const Point& p = points_[size_t(i)];
      const Shape now = shape_stress(p, U);
      std::fill(state, state + state_size(p), 0.0f);
      if (now.sound) put(state, now.S), state[6] = float(now.s);
    }
  }
}

const std::vector<float>& ViscousPoints::memory() const {
  settle();
  return state_;
}

bool ViscousPoints::fits(const std::vector<float>& s) const { return s.empty() || s.size() == state_.size(); }
void ViscousPoints::restore(const std::vector<float>& s) {
  state_ = s.empty() ? rest_ : s;
  in_step_ = owed_ = false;
}

}  // namespace limberg::fem
