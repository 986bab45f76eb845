#pragma once
// How stiff the spring of a place is that may touch something (contact_finder.h says why).
#include "sim/contact/contact_constants.h"
#include "sim/fem/model/fem_model.h"

namespace limberg {

/// Of the tissue in a cell copy: 3 mu, Young's modulus of what is nearly incompressible.
inline double young_kPa(const FemModel& model, int32_t copy) {
  return 3 * model.stencils[size_t(model.cells[size_t(copy)].stencil)].mu_kPa;
}

inline double contact_stiffness_N_per_mm(double weight, double young_kPa, double area_mm2, double cell_mm) {
  return 1e-3 * weight * contact_constants::stiffness * young_kPa * area_mm2 / cell_mm;
}

}  // namespace limberg
