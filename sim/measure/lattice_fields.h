#pragma once
// The fields of the lattice as it lies: what other programs draw and integrate.
//
//   displacement   of each node copy, x - X                                                                 mm
//   stretch        largest principal stretch of F F0 at the cell's sample point, prestretch included        1
//   stress         mean Cauchy stress of the cell, axes of the world, from the forces on its corners:       kPa
//                    sigma = sym( sum_a x_a (x) f_a ) / V,   V = J times the cell's volume at rest
//                  (the virial; for K it is the integral of mu F A F^T). f_a is the gradient of the plain energy
//                  (fem_model.h): K, lambda/2 (J - 1)^2 - p0 (J - 1), and the laws of its points. What layers that
//                  share a cell add to each other's slide, and what relaxes, is not in it.
//   pressure       - tr(sigma) / 3                                                                          kPa
//   material       index into Body::layers of the layer at the cell's centre
//   fraction       share of the cell that this copy has material in (HexCell::scale)
//   piece          connected piece of the lattice that it belongs to
//
// A cell that a cut divides is there once for each copy, each with nodes of its own, drawn whole.
#include <array>
#include <cstdint>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

class SoftTissue;

struct LatticeFields {
  // Per node copy.
  std::vector<Vec3f> X_mm, displacement_mm;
  // Per cell copy; corners in the order of fem_model.h: bit 0 = +x, bit 1 = +y, bit 2 = +z.
  std::vector<std::array<int32_t, 8>> node;
  std::vector<float> stretch, pressure_kPa, fraction;
  std::vector<std::array<float, 6>> stress_kPa;  // xx, yy, zz, xy, yz, xz
  std::vector<int32_t> material, piece;
};

LatticeFields lattice_fields(const SoftTissue& tissue);

}  // namespace limberg
