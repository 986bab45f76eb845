#include "sim/fem/elements/material_points.h"

#include <cmath>
#include <numeric>

#include "sim/base/error.h"

namespace limberg::fem {
namespace {

using Gradients = Eigen::Matrix<double, 8, 3>;
using Mat24 = Eigen::Matrix<double, 24, 24>;

const MaterialLaw& law_of(const FemModel& m, const MaterialPoint& p) {
  if (p.law < 0 || size_t(p.law) >= m.laws.size() || !m.laws[size_t(p.law)])
    throw InputError("", 0,
                     "a material point names law " + std::to_string(p.law) + "; one of the model's laws was expected");
  return *m.laws[size_t(p.law)];
}

}  // namespace

MaterialPoints::MaterialPoints(const FemModel& m) : laws_(m.laws) {
  std::vector<std::pair<int32_t, int32_t>> of_stencil;
  for (const Stencil& s : m.stencils) {
    const int32_t first = int32_t(points_.size());
    for (const MaterialPoint& p : s.points) {
      Point q;
      q.law = &law_of(m, p);
      q.BM = point_gradients(s, p, m.cell_mm) * p.M;
      q.M = p.M;
      q.volume_mm3 = p.volume_mm3;
      q.rest_kPa = q.law->at(p.M).energy_kPa;
      points_.push_back(q);
    }
    of_stencil.push_back({first, int32_t(points_.size())});
  }
  if (points_.empty()) return;
  std::vector<std::array<int32_t, 8>> nodes;
  std::vector<uint8_t> corners;
  for (const HexCell& c : m.cells) {
    const auto [first, last] = of_stencil[size_t(c.stencil)];
    if (first == last || c.scale == 0) continue;
    bool four = true;
    for (int32_t i = first; i < last && four; ++i) four = points_[size_t(i)].BM.bottomRows<4>().isZero(0);
    cells_.push_back({c.node, first, last, double(c.scale), uint8_t(four ? 4 : 8)});
    nodes.push_back(c.node), corners.push_back(cells_.back().corners);
  }
  scatter_ = CellScatter(nodes, m.X_mm.size(), corners);
  force_.resize(cells_.size());
  sums_.resize(cells_.size());
}

// Relative to the first corner: the gradients sum to zero, so the others' say all, and its force is what theirs leave.
template <int corners>
CellSums MaterialPoints::force(const Cell& cell, const NodeArray& u, bool measure, CellForce& out) const {
  constexpr int others = corners - 1;
  using Columns = Eigen::Matrix<double, 3, others>;
  const auto node = [&](int a) {
    const Node4& n = u[size_t(cell.node[size_t(a)])];
    return Vec3(double(n.x), double(n.y), double(n.z));
  };
  const Vec3 base = node(0);
  Columns U, f = Columns::Zero();
  for (int a = 0; a < others; ++a) U.col(a) = node(a + 1) - base;
  CellSums sums;
  for (int32_t i = cell.first; i < cell.last; ++i) {
    const Point& p = points_[size_t(i)];
    const auto BM = p.BM.template middleRows<others>(1);
    Mat3 FM = p.M;
    FM.noalias() += U * BM;
    const MaterialLaw::Response r = p.law->at(FM);
    sums.energy += p.volume_mm3 * (r.energy_kPa - p.rest_kPa);
    sums.magnitude += p.volume_mm3 * (std::fabs(r.energy_kPa) + p.rest_kPa);
    const Mat3 P = p.volume_mm3 * r.P_kPa;
    f.noalias() += P * BM.transpose();
  }
  f *= cell.scale;
  const auto put = [&](int a, const Vec3& v) {
    float* to = out.data() + 4 * a;
    for (int k = 0; k < 3; ++k) to[k] = float(v[k]);
    to[3] = measure ? float(v.norm()) : 0.0f;
  };
  put(0, -f.rowwise().sum());
  for (int a = 0; a < others; ++a) put(a + 1, f.col(a));
  return {cell.scale * sums.energy, cell.scale * sums.magnitude};
}

CellSums MaterialPoints::add(const NodeArray& u, NodeArray& g, bool measure, Workers& workers) const {
  if (empty()) return {};
  workers.parallel_for(cells_.size(), 64, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      const Cell& cell = cells_[c];
      sums_[c] = cell.corners == 4 ? force<4>(cell, u, measure, force_[c]) : force<8>(cell, u, measure, force_[c]);
    }
  });
  scatter_.add(force_, g, measure, workers);
  return total(sums_);
}

double points_force(const FemModel& m, const Stencil& s, const Vec3& cell_mm, const Gradients& u, Gradients& force) {
  force.setZero();
  double energy = 0;
  for (const MaterialPoint& p : s.points) {
    const MaterialLaw& law = law_of(m, p);
    const Gradients BM = point_gradients(s, p, cell_mm) * p.M;
    const MaterialLaw::Response r = law.at(p.M + u.transpose() * BM);
    energy += p.volume_mm3 * (r.energy_kPa - law.at(p.M).energy_kPa);
    force += p.volume_mm3 * BM * r.P_kPa.transpose();
  }
  return energy;
}

Mat24 points_tangent(const FemModel& m, const Stencil& s, const Vec3& cell_mm, const Gradients& u, bool project) {
  Mat24 H = Mat24::Zero();
  for (const MaterialPoint& p : s.points) {
    const Gradients BM = point_gradients(s, p, cell_mm) * p.M;
    const Mat9 C = law_of(m, p).tangent_kPa(p.M + u.transpose() * BM, project);
    Eigen::Matrix<double, 24, 9> B = Eigen::Matrix<double, 24, 9>::Zero();  // vec F is column-major
    for (int a = 0; a < 8; ++a)
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) B(3 * a + i, 3 * j + i) = BM(a, j);
    H.noalias() += p.volume_mm3 * (B * (C * B.transpose()).eval());
  }
  return H;
}

Mat3 scalar_stiffness_kPa(const MaterialLaw& law, const Mat3& F) {
  const Mat9 C = law.tangent_kPa(F, true);
  Mat3 D;
  for (int j = 0; j < 3; ++j)
    for (int l = 0; l < 3; ++l) D(j, l) = C.block<3, 3>(3 * j, 3 * l).trace() / 3;
  return D;
}

Mat8 points_scalar(const FemModel& m, const Stencil& s, const Vec3& cell_mm) {
  Mat8 K = Mat8::Zero();
  for (const MaterialPoint& p : s.points) {
    const Gradients BM = point_gradients(s, p, cell_mm) * p.M;
    K += p.volume_mm3 * (BM * scalar_stiffness_kPa(law_of(m, p), p.M) * BM.transpose());
  }
  return K;
}

Stencil law_stencil(const Vec3& cell_mm, int32_t law, const MaterialLaw& response, double lambda_kPa, double density,
                    const Mat3& M) {
  Stencil s;
  s.volume_mm3 = cell_mm.prod();
  s.density_kg_mm3 = density;
  s.lambda_kPa = lambda_kPa;
  s.mu_kPa = response.typical_stiffness_kPa(M);
  const Mat3 sigma = response.at(M).P_kPa * M.transpose() / M.determinant();
  s.p0_kPa = lambda_kPa > 0 ? sigma(2, 2) : 0;
  const double g = 0.5 / std::sqrt(3.0);
  for (int q = 0; q < 8; ++q) {
    MaterialPoint p;
    p.at = Vec3(q & 1 ? 0.5 + g : 0.5 - g, q & 2 ? 0.5 + g : 0.5 - g, q & 4 ? 0.5 + g : 0.5 - g);
    p.volume_mm3 = s.volume_mm3 / 8;
    p.law = law;
    p.M = M;
    s.points.push_back(p);
  }
  return s;
}

}  // namespace limberg::fem
