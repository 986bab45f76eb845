#pragma once
// Muscles and ligaments in the tissue between face and bone: bundles about a line, with fibres along it.
//
// A tetrahedron of the finite elements whose middle lies within radius_mm of the line is the bundle's instead of fat's:
// a matrix, and fibres along the nearest piece of the line that only pull (fibres.h). The topmost layer stays skin and
// fat, beneath which muscles lie. They hold by where they lie: nodes on bone go with it, fragments pull a bundle apart.
// They rest in the head's first shape, and do not pull by themselves.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/fem/materials/law.h"

namespace limberg::simplex {

struct FaceBundle {
  std::string name;
  std::vector<Vec3> path_mm;  // two places or more, at rest
  double radius_mm = 8;
  double young_kPa = 15;        // of the matrix; with no fibres a ligament of that stiffness
  double k1_kPa = 0, k2 = 0.2;  // of the fibres, as dispersed_fibres takes them; 0: none
};

struct InBundle {
  size_t bundle = 0, piece = 0;  // piece: from path_mm[piece] to the next place
};
/// Of several that have the place the last one.
std::optional<InBundle> bundle_at(std::span<const FaceBundle> bundles, const Vec3& X_mm);

/// Throws InputError on a path of less than two places or a piece of no length, a radius or modulus that is not
/// positive, fibre constants out of range (`poisson` as FaceElasticity has it).
LawPtr bundle_law(const FaceBundle& bundle, size_t piece, double poisson);

}  // namespace limberg::simplex
