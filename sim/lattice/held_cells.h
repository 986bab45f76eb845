#pragma once
// Cells with held corners: the displacement vanishes where the body ends, not at the lattice's nodes.
//
// Nodes beyond the held surface (or nearly on it) do not move. With trilinear functions the displacement of a cell then
// vanishes at those nodes, up to a cell below the place where the body is held. So such a cell has other functions:
// with g the distance to the held surface and d_b that of the free corners,
//
//   phi_a = N_a g / sum over free b of N_b d_b   at free corners,   the held ones share 1 - sum of phi,
//
// which vanish where g does and hold every displacement u = c g exactly. On a square whose corners are all free and
// where g is linear they are the trilinear functions, so that neighbours fit. K is integrated with them, by points.
// g is the plane through its corner values; a cell in which that is off by more than kBent of its edge (a crease of the
// held surface) keeps the trilinear functions.
//
// The kernel asks the change of volume of one gradient of trilinear functions: that at `sample`, times s, comes nearest
// to the mean of phi's. With V s^2 instead of V its energy is that of phi's. The forces at rest are given as they are
// (Stencil::rest_mN).
//
// Matter with material points (fibres, laws of their own) keeps trilinear functions as well.
#include <array>
#include <vector>

#include "sim/lattice/cut_cells.h"

namespace limberg {

struct HeldCorners {
  uint8_t held = 0;                  // bit per corner
  std::array<double, 8> depth_mm{};  // above the held surface, negative beyond it
};

/// Gives a finished stencil of a cell those functions; false: nothing was done. `unheld`: the share (0..1) of its K as
/// it was that stays beside the new one, for conditioning. `frames`: of each matter.
bool hold_at_surface(Stencil& s, const Vec3& cell_mm, const HeldCorners& corners, const std::vector<LayerPoint>& points,
                     const std::vector<LayerMatter>& matter, const std::vector<StretchFrame>& frames, double unheld);

}  // namespace limberg
