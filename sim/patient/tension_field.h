#pragma once
// What the tension map shows: at each surface vertex the largest principal stretch that the tissue carries, prestretch
// included, minus 1.
//
// The deformation gradient is constant per cell (its centre value), averaged to node copies by cell volume and
// interpolated by the embedding, so the map is continuous on each piece and never bleeds across a cut.
#include <vector>

#include "sim/body/skin.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/patient/snapshot.h"

namespace limberg {

class TensionField {
 public:
  /// Precomputes the prestretch at every vertex: its layer by depth, its frame by the skin above it.
  TensionField(const SurfaceTopology& topology, const Skin& skin);

  /// field[v] = largest singular value of F F0, minus 1. Resized to the number of vertices.
  void compute(const SurfaceTopology& topology, const ElasticSolver& solver, std::vector<float>& field);

 private:
  std::vector<Mat3> prestretch_;  // F0 per vertex
  std::vector<Mat3> node_F_;
  std::vector<double> node_volume_;
};

/// Prestretch F0 of a material in a skin frame, det F0 = 1 (see Material).
Mat3 prestretch_gradient(const Material& material, const Skin::Frame& frame);

}  // namespace limberg
