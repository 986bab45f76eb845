#pragma once
// A hyperelastic law: energy density as a function of the deformation gradient F = dx/dX, for any F, inverted ones too.
//
// A law holds the part of the energy that resists change of shape. Change of volume is the element's own
// (fem_model.h: lambda/2 (J - 1)^2 at one sample point per cell, with its multiplier), together with the
// linear pressure term that makes the reference state free of stress. A law may also hold a volumetric
// part itself (for comparison with codes that integrate everything fully); its entry then says that it is complete
// (catalogue.h) and the cell has lambda = 0.
//
// To add a material write one file:
//   1. the energy: an isotropic one is a small struct with value
//      and two derivatives in principal stretches (isotropic.h does
//      the rest, inversion included); anything else implements
//      MaterialLaw below. Lame's volume part does not belong in it.
//   2. a function that returns its LawCatalogue::Entry: name, keys
//      with ranges, and how constants make the law (catalogue.h)
// and add the entry to a copy of shipped_laws() (parse_scene takes one), or to shipped_laws() itself. Scenes can then
// name it, lattices make its points, `limberg check` lists it. A whole example of 30 lines: tests/app/test_own_law.cpp.
#include <memory>
#include <string>

#include "sim/geometry/vec.h"

namespace limberg {

using Mat9 = Eigen::Matrix<double, 9, 9>;

class MaterialLaw {
 public:
  virtual ~MaterialLaw() = default;

  struct Response {
    double energy_kPa = 0;      // density, per rest volume; 0 at F = I
    Mat3 P_kPa = Mat3::Zero();  // first Piola stress dW/dF
  };
  virtual Response at(const Mat3& F) const = 0;

  /// d vec(P) / d vec(F), vec column-major, symmetric. `project`: eigenvalues below zero are set to zero.
  virtual Mat9 tangent_kPa(const Mat3& F, bool project) const = 0;

  /// One modulus that stands for the law in a scalar preconditioner: the mean eigenvalue of its projected tangent at F.
  double typical_stiffness_kPa(const Mat3& F = Mat3::Identity()) const { return tangent_kPa(F, true).trace() / 9; }

  virtual std::string describe() const = 0;
};

using LawPtr = std::shared_ptr<const MaterialLaw>;

}  // namespace limberg
