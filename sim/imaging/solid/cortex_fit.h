#pragma once
// Where the surface of bone lies, to a part of a voxel, and how thick its cortex is.
//
// No isovalue is right everywhere: half-way between soft tissue and dense bone it loses thin cortex, below it makes
// thick bone thicker (by 1 mm on each side at 250 HU in voxels of 2 mm, synthetic head, 2026-11-27). So along the
// normal of a surface the picture is taken for three materials, blurred by the scanner,
//
//   I(t) = deep + (cortical - deep) P((t - inner) / s) - (cortical - soft) P((t - outer) / s)
//
// with P the normal distribution, s the standard deviation of the blur along this normal and `cortical` the density of
// compact bone, which is the same everywhere; deep (diploe, marrow, or soft tissue behind a thin wall), soft, inner and
// outer are found by least squares (Treece, Gee, Mayhew, Poole 2010; Levenberg and Marquardt's damping).
#include <array>
#include <span>

#include "sim/base/workers.h"
#include "sim/imaging/io/volume.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg {

struct Cortex {
  double outer_mm = 0, inner_mm = 0;  // along the normal, from where it was looked for; outer > inner
  double soft = 0, deep = 0;          // in the numbers of the volume
  double rms = 0;                     // of what is left
  bool found = false;                 // it came to an end, and outer lies within the profile
};
/// A grey value at a place: how far along the normal, outwards, and how much it counts.
struct ProfileSample {
  double at_mm = 0, value = 0, weight = 1;
};
/// What blurs a step along a profile: a normal distribution, and the slice's own height, which is a box.
struct Spread {
  double sd_mm = 1, box_mm = 0;
};
/// What is known beforehand, where slices are too tall to tell: mean and standard deviation; `noise`: of a grey value,
/// with what the model does not know.
struct CortexPrior {
  double soft = 45, soft_sd = 60, deep = 450, deep_sd = 250;
  double thickness_mm = 2, thickness_sd_mm = 1, outer_sd_mm = 5;
  double noise = 60;
};
/// In any order. Not found where there are fewer than five.
Cortex fit_cortex(std::span<const ProfileSample> samples, const Spread& spread, double cortical,
                  const CortexPrior* prior = nullptr);
/// `values` at even steps from inside (the first) to outside, the middle one at 0.
Cortex fit_cortex(std::span<const double> values, double step_mm, double blur_mm, double cortical);

/// The scanner's blur as standard deviations in mm along the axes of the volume: what voxels and the interpolation
/// between them add, and `point_mm`, its own.
struct Blur {
  Vec3 variance_mm2 = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  // columns: unit vectors along the axes of the volume
  double along(const Vec3& normal) const;
};
Blur blur_of(const Volume& volume, double point_mm);

struct CortexReport {
  int32_t vertices = 0, found = 0;  // the others follow their neighbours
  double cortical = 0;              // the density of compact bone that leaves the least
  double cortical_sd = 0;           // tall slices: of the densities that leave nearly as little
  double point_mm = 0;              // the scanner's own blur that leaves the least
  double shift_mm = 0;              // mean of the moves, outwards
  double thickness_mm = 0;          // median of the cortex
  std::vector<float> cortex_mm;     // per vertex slot; NaN where none was found
  int32_t sure = 0;                 // tall slices: found where the slices alone tell it
};
/// Moves the vertices of a closed mesh near the surface of bone to where the surface lies, along their normals, no
/// farther than `reach_mm`. `volume` is not smoothed. `densities`: of compact bone, of which the one is taken that fits
/// best. A scan in which no cortex is thicker than the blur cannot tell a denser one from a thicker one.
CortexReport put_on_cortex(simplex::Mesh& mesh, const Volume& volume, const std::vector<double>& densities,
                           double reach_mm, Workers& workers);

/// The same from slices that are taller than their pixels are wide, as they are: not interpolated. Across a surface
/// that stands upright each slice shows it as sharply as its pixels do, across one that lies flat the height of a slice
/// is a box that it is blurred with; between, both have their part. Around a vertex the slices near it are sampled
/// where their planes are, along the way that the surface's normal takes in them; each sample counts by its distance
/// along the normal. Where a profile has fewer samples than the model has numbers, what the upright surfaces say
/// (cortex, density beneath it) is taken for known beforehand. `offset`: what the numbers are above Hounsfield units.
/// `same_scan`: a larger bone of the same picture, whose density and blur are taken; a small one tells them badly.
CortexReport put_on_cortex_in_slices(simplex::Mesh& mesh, const Volume& slices, const std::vector<double>& densities,
                                     double offset, Workers& workers, const CortexReport* same_scan = nullptr);

}  // namespace limberg
