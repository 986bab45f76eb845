#include "sim/world/tension_field.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace limberg {

Mat3 prestretch_tensor(const Material& material, const Vec3& normal, const Vec3& tension_direction) {
  Vec3 along = tension_direction - tension_direction.dot(normal) * normal;
  if (along.norm() < 1e-6) along = normal.unitOrthogonal();
  along.normalize();
  const Vec3 across = normal.cross(along);
  const double l1 = material.prestretch_along, l2 = material.prestretch_across;
  return l1 * along * along.transpose() + l2 * across * across.transpose() + 1 / (l1 * l2) * normal * normal.transpose();
}

TensionField::TensionField(const SurfaceTopology& topology, const std::vector<Vec3>& skin_normal) {
  const Body& body = *topology.body;
  prestretch_index_.resize(topology.view.X_mm.size());
  for (size_t v = 0; v < prestretch_index_.size(); ++v) {
    double below = 0;
    size_t layer = 0;
    // The tolerance keeps skin vertices in the first layer: their depth is a distance computed in floating point.
    while (layer + 1 < body.layers.size() && topology.depth_mm[v] > (below += body.layers[layer].thickness_mm) + 1e-3) ++layer;
    const Mat3 F0 = prestretch_tensor(body.layers[layer].material, skin_normal[v], body.tension_direction);
    if (prestretch_.empty() || prestretch_.back() != F0) prestretch_.push_back(F0);
    prestretch_index_[v] = int32_t(prestretch_.size()) - 1;
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
    F *= prestretch_[size_t(prestretch_index_[v])];
    Eigen::SelfAdjointEigenSolver<Mat3> eigen;
    eigen.computeDirect(F.transpose() * F, Eigen::EigenvaluesOnly);
    field[v] = float(std::sqrt(std::max(0.0, eigen.eigenvalues()[2])) - 1);
  }
}

}  // namespace limberg
