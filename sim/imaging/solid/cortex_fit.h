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
  double point_mm = 0;              // the scanner's own blur that leaves the least
  double shift_mm = 0;              // mean of the moves, outwards
  double thickness_mm = 0;          // median of the cortex
  std::vector<float> cortex_mm;     // per vertex slot; NaN where none was found
};
/// `slice_mm` above 0: slices so far apart were interpolated by shape along axis 2, so that across a steep surface the
/// blur is that within a slice, and across a flat one that of a tall voxel: each vertex takes what fits it better.
/// Moves the vertices of a closed mesh near the surface of bone to where the surface lies, along their normals, no
/// farther than `reach_mm`. `volume` is not smoothed. `densities`: of compact bone, of which the one is taken that fits
/// best. A scan in which no cortex is thicker than the blur cannot tell a denser one from a thicker one.
CortexReport put_on_cortex(simplex::Mesh& mesh, const Volume& volume, const std::vector<double>& densities,
                           double reach_mm, Workers& workers, double slice_mm = 0);

}  // namespace limberg
