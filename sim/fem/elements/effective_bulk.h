// How stiff a cell is against a change of its volume, as the minimiser meets it.
// Nearly incompressible cells carry a pressure of their own (augmented Lagrangian)
// beside a moderate penalty k; eliminating the pressure leaves lambda and k in series.
#pragma once

#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

/// k in kPa: 3 mu; twice that where layers share a cell, so that
/// more of their stretch is taken at its place (layer_slide.h).
double penalty_kPa(const Stencil& s);

/// Whether the cell carries a pressure: its Poisson's ratio is above 0.4, and `augmented` asks for it.
bool uses_multiplier(const Stencil& s, bool augmented);

/// Effective volumetric stiffness ke in kPa of a stencil, as it
/// enters gradient and preconditioner: lambda k / (lambda + k).
double effective_bulk_kPa(const Stencil& s, bool augmented);

}  // namespace limberg::fem
