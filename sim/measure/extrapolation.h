#pragma once
// What a figure would be on an infinitely fine lattice, from the figure at two or more cell sizes.
//
// With three sizes or more f = f0 + c h^p is fitted by least squares, once with all sizes alike and once with the finer
// the heavier, and the fit of less spread sigma is kept; three sizes that settle lie on it (Richardson). Where p is one
// that the method has, .5 to 2 (trilinear cells give 2, next to a cut 1), the error is
//
//   1.25 |f1 - f0| + sigma + |f1 - fit(h1)|
//
// with f1 at the finest size. Where it is not, p = 1 or 2 is taken for granted, whichever spreads less, with 3 for
// 1.25, nothing is extrapolated, and the text says that the sizes are not in the asymptotic range. Where sigma exceeds
// the mean change from size to size, all is multiplied by 3 sigma over that change, with 1 for 1.25 (Eca and Hoekstra,
// J. Comput. Phys. 262, 2014, without their fit of h and h^2 together). Sizes in a ratio of 1.4 cannot tell orders 1
// and 2 where values scatter: above order 1 the error is no less than a fit with p = 1 through the sizes up to twice
// the finest gives, with 1 for 1.25. Two sizes: p = 1 with the factor 3 (Roache 1994).
//
// Does it cover? Twelve figures of the shipped rhomboid and Z-plasty at seven choices of three to five sizes of 7 to
// 1.75 mm (2026-11-26): the value at 1.75 mm lay beyond the error in 0 of 154, a line through the four finest at h = 0
// in 19. Three sizes by Richardson, 3.5 the highest order, three times the largest change else: in 19 and 42. Made-up
// figures that scatter by up to a fifth of their error: 90 to 100 % covered.
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
