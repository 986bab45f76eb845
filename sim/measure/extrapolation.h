#pragma once
// What a figure would be on an infinitely fine lattice, from the figure at two or more cell sizes.
//
// With the three finest sizes h1 < h2 < h3 and f = f0 + c h^p, the observed order p solves
//
//   (h3^p - h2^p) / (h2^p - h1^p) = (f3 - f2) / (f2 - f1)
//
// whose left side rises with p (Richardson; for unequal ratios Celik et al., J. Fluids Eng. 130,
// 2008, have the same equation in another form). Then f0 = f1 - (f2 - f1) h1^p / (h2^p - h1^p),
// and the error is the grid convergence index: 1.25 times the distance to f0. Where that law does
// not describe the figures (they swing, do not settle, or the order is not one that the method
// has: trilinear cells give 2, next to a cut 1) nothing is extrapolated, the text says that the
// sizes are not in the asymptotic range, and the error is three times the largest change among
// the three. Two sizes: order 1 is taken for granted, with the factor 3 (Roache 1994).
#include <optional>
#include <span>
#include <string>

namespace limberg {

struct Extrapolation {
  double value = 0;                    // at the finest size
  std::optional<double> error;         // estimated, in the figure's unit, >= 0; none with one size
  std::optional<double> order;         // observed, where the equation has a root
  std::optional<double> extrapolated;  // only in the asymptotic range
  bool asymptotic = false;
  std::string says;  // one line
};

/// `cell_mm` and `value` in any order, sizes positive and different, same length, finite; `noise`: changes up to this
/// are the solver's own error, not the lattice's. InputError otherwise.
Extrapolation extrapolate(std::span<const double> cell_mm, std::span<const double> value, double noise = 0);

}  // namespace limberg
