#pragma once
// The region of interest of a scene: tissue outside it is part of the
// body (seen, cut, undone) but holds still and is no work for the solver.
//
// A node farther than the radius from the axis through the chart's origin along its normal is held;
// a cell of nothing but such nodes has scale 0: the solver of such a scene (fem/region_solver.h)
// has neither unknowns nor elements there. So the solution is that of the region with a held rim.
#include <memory>

#include "sim/body/body.h"
#include "sim/fem/model/fem_model.h"

namespace limberg {

/// `radius_mm` <= 0: the model as it is.
std::shared_ptr<const FemModel> hold_outside(std::shared_ptr<const FemModel> model, const Body& body, double radius_mm);

}  // namespace limberg
