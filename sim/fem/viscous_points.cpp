#include "sim/fem/viscous_points.h"

#include <Eigen/LU>
#include <cmath>

#include "sim/error.h"

namespace limberg::fem {
namespace {

constexpr double kLeastJ = 0.2;  // below it ln J goes on as a parabola, and no stress of shape is remembered

void put(float* to, const Mat3& S) {
  const double v[6] = {S(0, 0), S(1, 1), S(2, 2), S(0, 1), S(1, 2), S(2, 0)};
  for (int i = 0; i < 6; ++i) to[i] = float(v[i]);
}
Mat3 get(const float* v) {
  Mat3 S;
  S << double(v[0]), double(v[3]), double(v[5]), double(v[3]), double(v[1]), double(v[4]), double(v[5]), double(v[4]), double(v[2]);
  return S;
}
Mat3 cofactor(const Mat3& F) {
  Mat3 C;
  C << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return C;
}
/// L and L' at J. Where the layer's own pressure s is negative a straight line keeps the energy bounded.
std::pair<double, double> log_volume(double J, double s) {
  if (s < 0) return {J - 1, 1};
  if (J >= kLeastJ) return {std::log(J), 1 / J};
  const double x = (J - kLeastJ) / kLeastJ;
  return {std::log(kLeastJ) + x - 0.5 * x * x, (1 - x) / kLeastJ};
}

}  // namespace

ViscousPoints::ViscousPoints(const FemModel& m) : laws_(m.laws) {
  std::vector<std::pair<int32_t, int32_t>> of_stencil;
  for (const Stencil& s : m.stencils) {
    const int32_t first = int32_t(points_.size());
    for (const ViscousPoint& p : s.viscous) {
      if (p.law < 0 || size_t(p.law) >= laws_.size() || !laws_[size_t(p.law)])
        throw InputError("", 0, "a viscous point names law " + std::to_string(p.law) + "; one of the model's laws was expected");
      Point q;
      q.law = laws_[size_t(p.law)].get(), q.law_index = p.law;
      q.B = trilinear_gradients(s, p.at, m.cell_mm);
      q.M = p.M, q.BM = q.B * p.M;
      q.volume_mm3 = p.volume_mm3;
      q.rest_kPa = q.law->at(p.M).energy_kPa;
      q.term = p.terms;
      points_.push_back(std::move(q));
    }
    of_stencil.push_back({first, int32_t(points_.size())});
  }
  if (points_.empty()) return;
  std::vector<std::array<int32_t, 8>> nodes;
  place_.assign(m.cells.size(), -1);
  size_t size = 0;
  for (size_t c = 0; c < m.cells.size(); ++c) {
    const HexCell& cell = m.cells[c];
    const auto [first, last] = of_stencil[size_t(cell.stencil)];
    if (first == last) continue;
    place_[c] = int32_t(cells_.size());
    cells_.push_back({cell.node, int32_t(c), first, last, int32_t(size), double(cell.scale)});
    nodes.push_back(cell.node);
    for (int32_t i = first; i < last; ++i) size += state_size(points_[size_t(i)]);
  }
  scatter_ = CellScatter(nodes, m.X_mm.size());
  force_.resize(cells_.size()), sums_.resize(cells_.size());
  state_.assign(size, 0);
  relax(NodeArray(m.X_mm.size()));
  rest_ = state_;
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
  const Mat3 F = p.M + U.transpose() * p.BM;
  Shape r;
  if (!(F.determinant() > kLeastJ)) return r;
  const Mat3 inverse = F.inverse(), S = inverse * p.law->at(F).P_kPa;
  r.s = (S * (F.transpose() * F)).trace() / 3;
  r.S = S - r.s * inverse * inverse.transpose();
  r.sound = r.S.allFinite();
  return r;
}

void ViscousPoints::carry(const ViscousPoints& before, const ParentList& parent, const NodeArray& u) {
  if (empty()) return;
  relax(u);
  for (const Cell& c : cells_) {
    if (size_t(c.cell) >= parent.size() || parent[size_t(c.cell)] < 0 || size_t(parent[size_t(c.cell)]) >= before.place_.size()) continue;
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

void ViscousPoints::begin_step(double dt_s) {
  if (empty()) return;
  in_step_ = true;
  for (Point& p : points_) {
    p.a.clear(), p.h.clear(), p.G = 0;
    for (const auto& t : p.term) {
      p.a.push_back(std::exp(-dt_s / t.time_s));
      p.h.push_back(std::exp(-0.5 * dt_s / t.time_s));
      p.G += t.ratio * p.h.back();
    }
  }
}

CellSums ViscousPoints::add(const NodeArray& u, NodeArray& g, bool measure, Workers& workers) const {
  if (empty() || !in_step_) return {};
  workers.parallel_for(cells_.size(), 64, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      const Cell& cell = cells_[c];
      const Mat83 U = gather(cell, u);
      Mat83 f = Mat83::Zero();
      CellSums sums;
      const float* state = state_.data() + cell.state;
      for (int32_t i = cell.first; i < cell.last; ++i) {
        const Point& p = points_[size_t(i)];
        const double s = double(state[6]);
        Mat3 B = -p.G * get(state);
        for (size_t t = 0; t < p.term.size(); ++t) B += p.a[t] * get(state + 7 + 6 * t);
        state += state_size(p);
        const Mat3 grad = Mat3::Identity() + U.transpose() * p.B, F = p.M + U.transpose() * p.BM;
        const MaterialLaw::Response r = p.law->at(F);
        const auto [L, L1] = log_volume(grad.determinant(), s);
        // B : C relative to rest, from the change of F: no large numbers are subtracted.
        const Mat3 dF = F - p.M, dC = p.M.transpose() * dF + dF.transpose() * F;
        const double shape = p.G * (r.energy_kPa - p.rest_kPa), memory = 0.5 * B.cwiseProduct(dC).sum(), volume = p.G * s * L;
        sums.energy += p.volume_mm3 * (shape + memory - volume);
        sums.magnitude += p.volume_mm3 * (std::fabs(shape) + std::fabs(memory) + std::fabs(volume));
        f.noalias() += p.volume_mm3 * (p.BM * (p.G * r.P_kPa + F * B).transpose() - p.G * s * L1 * p.B * cofactor(grad).transpose());
      }
      sums_[c] = {cell.scale * sums.energy, cell.scale * sums.magnitude};
      force_[c] = cell_force(f, cell.scale);
    }
  });
  scatter_.add(force_, g, measure, workers);
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
  in_step_ = false;
  for (const Cell& c : cells_) {
    const Mat83 U = gather(c, u);
    float* state = state_.data() + c.state;
    for (int32_t i = c.first; i < c.last; state += state_size(points_[size_t(i)]), ++i) {
      const Point& p = points_[size_t(i)];
      const Shape now = shape_stress(p, U);
      std::fill(state, state + state_size(p), 0.0f);
      if (now.sound) put(state, now.S), state[6] = float(now.s);
    }
  }
}

bool ViscousPoints::fits(const std::vector<float>& s) const { return s.empty() || s.size() == state_.size(); }
void ViscousPoints::restore(const std::vector<float>& s) { state_ = s.empty() ? rest_ : s, in_step_ = false; }

}  // namespace limberg::fem
