#include "sim/measure/lattice_fields.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "sim/lattice/region_cells.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/tension_field.h"

namespace limberg {

namespace {

using Corners = Eigen::Matrix<double, 8, 3>;

Mat3 cofactor(const Mat3& F) {
  Mat3 c;
  c.row(0) = F.row(1).cross(F.row(2));
  c.row(1) = F.row(2).cross(F.row(0));
  c.row(2) = F.row(0).cross(F.row(1));
  return c;
}

/// dE/dx of a whole cell of that stencil, one row per corner, mN.
Corners cell_forces(const FemModel& m, const Stencil& s, const Corners& X, const Corners& u) {
  const Corners x = X + u;
  const Corners B = volume_gradients(s, m.cell_mm);
  const Mat3 F = Mat3::Identity() + u.transpose() * B;
  const double p = s.lambda_kPa * (F.determinant() - 1);
  Corners f;
  if (s.rest_mN) {  // K is no integral there: it acts on what has changed since rest
    f = s.K * u + *s.rest_mN +
        s.volume_mm3 * B * ((p - s.p0_kPa) * (cofactor(F) - Mat3::Identity()) + p * Mat3::Identity()).transpose();
  } else {
    f = s.K * x + s.volume_mm3 * (p - s.p0_kPa) * B * cofactor(F).transpose();
  }
  for (const MaterialPoint& q : s.points) {
    const Corners G = point_gradients(s, q, m.cell_mm);
    const Mat3 P = m.laws[size_t(q.law)]->at((Mat3::Identity() + u.transpose() * G) * q.M).P_kPa * q.M.transpose();
    f += q.volume_mm3 * G * P.transpose();
  }
  return f;
}

float largest_stretch(const Mat3& F) {
  Eigen::SelfAdjointEigenSolver<Mat3> eigen;
  eigen.computeDirect(F.transpose() * F, Eigen::EigenvaluesOnly);
  return float(std::sqrt(std::max(0.0, eigen.eigenvalues()[2])));
}

}  // namespace

LatticeFields lattice_fields(const SoftTissue& tissue) {
  const ElasticSolver& solver = tissue.solver();
  const FemModel& m = solver.model();
  const Skin skin(tissue.spec().body);
  const std::span<const Vec3f> u = solver.displacement_mm();
  const std::shared_ptr<const LatticeTopology> lattice = tissue.lattice();
  LatticeFields out;
  out.displacement_mm.assign(u.begin(), u.end());
  out.X_mm.reserve(u.size());
  for (size_t n = 0; n < m.X_mm.size(); ++n) out.X_mm.push_back(m.X_mm[n].cast<float>());
  Bvh::Closest near;
  Skin::Near of_region;
  for (size_t c = 0; c < m.cells.size(); ++c) {
    const HexCell& cell = m.cells[c];
    if (!(cell.scale > 0)) continue;
    const Stencil& s = m.stencils[size_t(cell.stencil)];
    Corners X, moved;
    for (int a = 0; a < 8; ++a) {
      X.row(a) = m.X_mm[size_t(cell.node[size_t(a)])].transpose();
      moved.row(a) = u[size_t(cell.node[size_t(a)])].cast<double>().transpose();
    }
    const Vec3 centre = X.colwise().mean().transpose();
    const double depth_mm = skin.depth_mm(centre, near);
    const int layer = skin.layer_at(skin.in_layers_mm(depth_mm, near));
    const Mat3 F = solver.cell_F(int32_t(c));
    const MatterAt of = matter_at(skin, centre, layer, of_region);
    const Mat3 F0 = prestretch_gradient(*of.material, {of.frame.normal, of.frame.along, of.frame.across});
    const Mat3 virial = (X + moved).transpose() * cell_forces(m, s, X, moved);
    const double J = (Mat3::Identity() + moved.transpose() * volume_gradients(s, m.cell_mm)).determinant();
    // A cell that is inside out has a negative volume, and no stress that means anything: it is told as it comes.
    const Mat3 sigma = (virial + virial.transpose()) / (2 * (std::abs(J) > 1e-6 ? J : 1e-6) * s.volume_mm3);
    out.node.push_back(cell.node);
    out.stretch.push_back(largest_stretch(F * F0));
    out.stress_kPa.push_back({float(sigma(0, 0)), float(sigma(1, 1)), float(sigma(2, 2)), float(sigma(0, 1)),
                              float(sigma(1, 2)), float(sigma(0, 2))});
    out.pressure_kPa.push_back(float(-sigma.trace() / 3));
    out.material.push_back(int32_t(of.matter));
    out.fraction.push_back(cell.scale);
    out.piece.push_back(lattice && c < lattice->cells.size() ? lattice->cells[c].piece : 0);
  }
  return out;
}

}  // namespace limberg
