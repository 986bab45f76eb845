#pragma once
// A membrane that cannot leave its plane, as a law of the lattice's own cells: the control without height.
//
//   W = mu/2 ( |F2|^2 + 1/J2^2 - 3 )  +  k/2 ( F13^2 + F23^2 + F31^2 + F32^2 + (F33 - t)^2 )
//
// F2 is the 2 x 2 block of the deformation gradient in the plane (the body's z is its normal), J2 its
// determinant: a membrane of a neo-Hookean material of constant volume under plane stress, whose
// thickness has been eliminated. The second part keeps both faces of the cells together and knows
// nothing of the first: u_z = 0 is a minimum, whatever happens in the plane, so nothing can buckle. t
// is the prestretch of the thickness, so that nothing pushes at rest. Below J2 = 0.3 the term 1/J2^2
// goes on as the parabola with its value, slope and curvature there, so that inverted cells come back.
//
// A layer of law "plane-membrane" takes mu_kPa, faces_kPa (k) and rest_thickness (t).
#include <memory>

#include "sim/fem/materials/catalogue.h"

namespace limberg::study {

LawPtr plane_membrane(double mu_kPa, double faces_kPa, double rest_thickness);

/// The shipped laws and this one.
std::shared_ptr<const LawCatalogue> laws_with_membrane();

/// A layer of it; prestretched alike in all directions of the plane. Its cells keep no volume of their own (lambda is a
/// thousandth of mu, the least that a cell may have).
Material membrane_material(double mu_kPa, double prestretch);

}  // namespace limberg::study
