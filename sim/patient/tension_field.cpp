#include "sim/patient/tension_field.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "sim/lattice/region_cells.h"

namespace limberg {

Mat3 prestretch_gradient(const Material& material, const Skin::Frame& frame) {
  const double along = material.prestretch_along, across = material.prestretch_across;
  return along * frame.along * frame.along.transpose() + across * frame.across * frame.across.transpose() +
         1 / (along * across) * frame.normal * frame.normal.transpose();
}

TensionField::TensionField(const SurfaceTopology& topology, const Skin& skin) {
  const SharedArray<float>& depth = topology.layers_mm.get();
  Skin::Near near;
  prestretch_.resize(topology.view.X_mm.size());
  for (size_t v = 0; v < prestretch_.size(); ++v) {
    const MatterAt of = matter_at(skin, topology.view.X_mm[v], skin.layer_at(depth[v]), near);
    prestretch_[v] = prestretch_gradient(*of.material, {of.frame.normal, of.frame.along, of.frame.across});
  }
}

void TensionField::compute(const SurfaceTopology& topology, const ElasticSolver& solver, std::vector<float>& field) {
  const FemModel& model = solver.model();
  node_F_.assign(model.X_mm.size(), Mat3::Zero());
  node_volume_.assign(model.X_mm.size(), 0);
  for (size_t c = 0; c < model.cells.size(); ++c) {
    const HexCell& cell = model.cells[c];
    const Mat3 F = solver.cell_F(int32_t(c));
    const double volume = double(cell.scale) * model.stencils[size_t(cell.stencil)].volume_mm3;
    for (int32_t n : cell.node) {
      node_F_[size_t(n)] += volume * F;
      node_volume_[size_t(n)] += volume;
    }
  }
  for (size_t n = 0; n < node_F_.size(); ++n)
    if (node_volume_[n] > 0) node_F_[n] /= node_volume_[n];
  field.resize(topology.view.X_mm.size());
  for (size_t v = 0; v < field.size(); ++v) {
    const EmbeddedPoint& e = topology.embedding[v];
    Mat3 F = Mat3::Zero();
    for (size_t i = 0; i < 8; ++i) F += double(e.w[i]) * node_F_[size_t(e.node[i])];
    F *= prestretch_[v];
    Eigen::SelfAdjointEigenSolver<Mat3> eigen;
    eigen.computeDirect(F.transpose() * F, Eigen::EigenvaluesOnly);
    field[v] = float(std::sqrt(std::max(0.0, eigen.eigenvalues()[2])) - 1);
  }
}

}  // namespace limberg
