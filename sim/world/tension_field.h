#pragma once
// What the tension map shows: at each surface vertex the largest principal stretch that the tissue carries, prestretch
// included, minus 1.
//
// The deformation gradient is constant per cell (its centre value), averaged to node copies by cell volume and
// interpolated by the embedding, so the map is continuous on each piece and never bleeds across a cut.
#include <vector>

#include "sim/fem/elastic_solver.h"
#include "sim/snapshot.h"

namespace limberg {

class TensionField {
 public:
  /// Precomputes the prestretch at every vertex: its layer by depth, its frame by the nearest skin normal.
  TensionField(const SurfaceTopology& topology, const std::vector<Vec3>& skin_normal);

  /// field[v] = largest singular value of F F0, minus 1. Resized to the number of vertices.
  void compute(const SurfaceTopology& topology, const ElasticSolver& solver, std::vector<float>& field);

 private:
  std::vector<Mat3> prestretch_;           // the distinct F0
  std::vector<int32_t> prestretch_index_;  // per vertex
  std::vector<Mat3> node_F_;
  std::vector<double> node_volume_;
};

/// Prestretch of a layer in the frame (along the tension lines, across them, through the skin): F0 with det F0 = 1.
/// `tension_direction` is projected into the skin plane; where it is parallel to the normal, any direction serves.
Mat3 prestretch_tensor(const Material& material, const Vec3& normal, const Vec3& tension_direction);

}  // namespace limberg
