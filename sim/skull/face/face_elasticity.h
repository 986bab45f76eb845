#pragma once
// The tissues between skull and face as one elastic body: the tetrahedra that build_tissue has made anyway, with the
// solver of sim/fem.
//
// Nodes under the tissue are held where the bone is; all others are free: the
// skin and the sides carry no load. Stable neo- Hookean fat; the top layer is a
// mixture by thickness of fat and skin, a membrane as far as one layer of
// tetrahedra can be one; below it muscles may lie (face_bundle.h), and on bone
// what lets skin slide (face_slide.h). Tissues of
// neighbouring regions share the nodes on the skin where their regions meet.
// Linear tetrahedra lock as Poisson's ratio goes to 1/2: 0.45 is as far as it
// should go, and one layer has no inner nodes.
#include <memory>
#include <span>
#include <vector>

#include "sim/base/workers.h"
#include "sim/skull/face/face_bundle.h"
#include "sim/skull/face/face_slide.h"
#include "sim/skull/simplex/tissue.h"

namespace limberg::simplex {

struct ElasticitySettings {
  double poisson = 0.45;  // 0..0.49
  double skin_mm = 2;     // thickness of the skin, part of the top layer
  double skin_kPa = 60;   // its Young modulus; 0: fat alone
  std::vector<FaceBundle> bundles;
  std::vector<FaceSlide> slides;  // of tissues of two layers or more
};

/// Young's modulus of a tissue's top layer: skin and fat by their shares of its mean thickness.
double top_layer_kPa(const Tissue& tissue, double young_kPa, const ElasticitySettings& settings);

class FaceElasticity {
 public:
  struct Body {
    const Tissue* tissue = nullptr;
    double young_kPa = 10;  // of the fat
  };
  /// Throws InputError on moduli that are not positive and finite, or a body without tetrahedra, and what bundle_law()
  /// refuses.
  FaceElasticity(std::span<const Body> bodies, const ElasticitySettings& settings, Workers& workers);
  ~FaceElasticity();

  size_t nodes() const;
  /// The number here of node i of a body (welded nodes have one).
  int32_t node(size_t body, size_t i) const { return node_[body][i]; }
  /// How many tetrahedra each of the bundles has, and their volume; of what slides the same.
  struct Bundled {
    int tetrahedra = 0;
    double volume_mm3 = 0;
  };
  const std::vector<Bundled>& bundled() const { return bundled_; }
  const std::vector<Bundled>& sliding() const { return sliding_; }
  bool held(int32_t node) const { return held_[size_t(node)]; }
  /// Holds other nodes than the bones' (tests). One flag per node.
  void hold(std::span<const uint8_t> held);

  struct Report {
    int iterations = 0;
    double residual = 0, distance_mm = 0;  // fem/elastic_solver.h
    int inverted = 0;
    bool converged = false;  // or as near as single precision comes
  };
  /// From the displacements given (mm per node: where the held ones go, where the others begin) so many iterations
  /// towards equilibrium, in place.
  Report step(std::vector<Vec3>& displacement_mm, int iterations, double tolerance);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::vector<std::vector<int32_t>> node_;
  std::vector<uint8_t> held_;
  std::vector<Bundled> bundled_, sliding_;
};

}  // namespace limberg::simplex
