#pragma once
// Cells that layers share: what a trilinear displacement gets wrong in them, put right in the stencil.
//
// K is the exact integral of mu/2 |grad u|^2 over the layers, but not every trilinear displacement is what tissue does:
//   sliding   layers of different stiffness shear differently. The mean of the
//             gradient along the normal N is weighed with the harmonic mean of
//             the moduli, and Stencil::slide_kPa keeps the rest
//             (layer_slide.h). 3 % of the difference stays: a stiff layer that
//             bends over a length of few cells takes its soft neighbour along.
//   bending   u = z x along T has the strain z, which is wanted, and the
//             shear x, which a bent plate does not have: its normals stay
//             normal. What varies along the layers in the gradient along N
//             is therefore left out, and what varies across them (about
//             their neutral plane) in gradients along T is weighed with the
//             modulus of a plate that may grow thin, E' = bending_over_mu
//             mu: from E of a strip, which curves across by itself, a
//             quarter of the way to E / (1 - nu^2) of a plate, which must
//             not. (A stiff layer that is resolved by cells has this from
//             their volumes.) Of it comes off what the stretch energy adds,
//             asked at two places a distance d apart (layer_slide.h): a = 4
//             r (1 - r) d^2 V p0 / M2 in units of mu, M2 the second moment
//             of the moduli about the neutral plane. It grows with the
//             square of the sum of both curvatures, as a plate's: at a = 2
//             and E' = 2 mu they are the plate's law. So E' takes 3/4 a off,
//             which keeps the mean of strip and plate; it stays at least mu.
// The quarter and the 3 % were chosen on the cases of `bench laws` (2026-11-21); the rest has no number in it.
// All of it vanishes for a homogeneous gradient: rest, rigid motions and even stretch are as before.
//
// Only cells with two or more layers that differ, all of them with a matrix modulus (laws of points hold their own
// shape), that the body fills by a quarter at least: with less, the centre, where the volume and what slides are
// measured, lies beside the matter, and free corners there are drawn out by metres. A cell that the body does not fill
// has the bending, if only one layer is in it: without that a sheet of a thickness t in a cell of edge h would be
// (h / t)^2 times as stiff as the shear x of its parts makes a cube of it.
#include <array>
#include <vector>

#include "sim/lattice/stencil_integrals.h"

namespace limberg {

/// 1.5 (1 + nu) + 0.5 / (1 - nu).
double bending_over_mu(double poisson);

/// Integrals over the part of a cell that is of one layer: x (mm, from the cell's centre), B = grad N.
struct LayerMoments {
  double volume_mm3 = 0;
  Vec3 x = Vec3::Zero();
  Mat3 xx = Mat3::Zero();
  Eigen::Matrix<double, 8, 3> B = Eigen::Matrix<double, 8, 3>::Zero();
  std::array<Eigen::Matrix<double, 8, 3>, 3> Bx{B, B, B};
  void add(const LayerMoments& o, double sign = 1);
};

/// Of the box [lo, hi] (cell units).
LayerMoments box_moments(const Vec3& cell_mm, const Vec3& lo, const Vec3& hi);

struct LayerPart {
  const LayerMatter* matter = nullptr;
  LayerMoments moments;
};
/// After finish_stencil. `cut`: the body does not fill the cell; then one layer, too, bends as a plate of its own
/// thickness. `slides`: sliding counts. It is asked at the cell's centre, which leaves a force at rest where layers lie
/// askew in the cell: a part of their moduli's difference, little for skin on fat and too much for cartilage.
void share_cell(Stencil& s, const Vec3& cell_mm, const std::vector<LayerPart>& parts, const StretchFrame& frame,
                bool cut = false, bool slides = true);

}  // namespace limberg
