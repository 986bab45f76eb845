#pragma once
// What layers of different stiffness add to the energy of a cell that they share.
//
// A trilinear displacement gives all layers of a cell the same
// shear, and its volume can be asked at one place only. So:
//
// Sliding. One shear makes a stiff layer stiffen a soft one under it: their moduli count with the mean mu_m
// = sum phi mu, where a laminate has the harmonic mean, 1 / mu_h = sum phi / mu (traction across the layers
// is the same in each). Let every layer have a gradient F + a_l N^T, N their normal, sum phi_l a_l = 0, and
// all keep the cell's volume: a_l . n = 0 with n = cof F N. The least energy over a_l is in closed form,
//
//   mu_m/2 |F|^2  -  slide/2 |P F N|^2,     slide = mu_m - mu_h,  P = I - n n^T / |n|^2,  |P F N|^2 = |F
//                                                                                         N|^2 - (J / |n|)^2
//
// The term in |F N|^2 is quadratic and goes into the stencil's K (shared_cells.h). Left is, at the cell's centre,
//
//   W(F) = slide/2 J^2 g(|n|^2),   g(s) = 1/s down to s = 1/4, below that its
//                                  parabola there: bounded where a cell is flattened.
//
// What the layers give way ends as it grows: with the slip x = |F N|^2 - J^2 g(|n|^2) the energy slide/2
// x^2 / (x + 2.5) is added. It is of fourth order for small slips and makes the moduli's mean count again
// at large ones; without it a scrambled cell with layers of a hundredfold contrast may stay folded over.
//
// Stretch. Volume is kept by the cell as a whole (J at its centre), but
// every layer has the area that its own place has, and grows thinner
// accordingly. Given the area |n|^2 = s, the thickness t of least energy
// mu/2 t^2 - mu (t sqrt(s) - 1) + lambda/2 (t sqrt(s) - 1)^2 leaves
//
//   S(s) = - mu L (s - 1) / (2 (L + lambda (s - 1))),   L = mu + lambda,   mu = p0
//
// S at the sample point is added and S at the centre taken away: nothing in an even stretch, the plate's
// own stiffness where the cell is bent. lambda is here what the minimiser meets (effective_bulk_kPa:
// near 6 mu for nearly incompressible tissue); with more, S at the centre would outweigh the cell's own
// resistance while its multiplier is not there yet. So the sample point gets r = lambda / L of the
// stretch and the centre keeps the rest; what that adds to bending is known (shared_cells.h).
//
// Neither knows a rotation. At rest their slopes are those that K and p0 lack.
#include "sim/fem/materials/law.h"

namespace limberg::fem {

struct LayerEnergy {
  double energy = 0;
  Mat3 slope = Mat3::Zero();  // dW/dF
};
/// W and what ends the slip, of slide = 1. `axes`: Stencil::slide_axes. The tangent is d2W/dF2, vec F column-major.
LayerEnergy layer_slide(const Mat3& F, const Mat3& axes);
Mat9 layer_slide_tangent(const Mat3& F, const Mat3& axes);

/// S.
LayerEnergy layer_stretch(const Mat3& F, const Mat3& axes, double p0_kPa, double lambda_kPa);
Mat9 layer_stretch_tangent(const Mat3& F, const Mat3& axes, double p0_kPa, double lambda_kPa);

/// d2J/dF2 of J = det F.
Mat9 determinant_tangent(const Mat3& F);

}  // namespace limberg::fem
