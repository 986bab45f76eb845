#pragma once
// Slices between tall ones, by shape: a skull in slices of 5 mm has no terraces.
//
// In each slice the signed distance to its contour at the isovalue is found, in mm, above 0 inside. The contour is that
// of linear interpolation along the sides of the pixels, so it lies between pixels. Distances are interpolated linearly
// from slice to slice; where they are 0 is the new contour. (Raya and Udupa 1990, Shape-based interpolation of
// multidimensional objects; Herman, Zheng and Bucholtz 1992, Shape-based interpolation. Both as remembered.)
//
// Grey values. A new pixel with distance d takes from each of both slices the grey value where the distance there is d
// too, on the straight line through the pixel and its nearest place of that slice's contour, and mixes both linearly.
// So the profile across a surface stays what it was in the slices, and falls through the isovalue where d is 0. Both
// values are held on the side of the isovalue that d says, where a structure is thinner than the way along the line.
// Farther than two gaps from both contours on the same side grey values are interpolated straight up; between, the way
// along the line fades. A slice without a contour counts as one gap away from it; its own grey values come in with the
// distance from the surface. Slices that were there keep their values, bit for bit.
#include "sim/base/workers.h"
#include "sim/imaging/io/volume.h"

namespace limberg {

/// Along the axis with the longest step, if that is more than 1.5 times the longer of the other two: slices in between,
/// so that the step is the gap divided by a whole number and as near to `step_mm` as such come. Any other volume comes
/// back as it is. `iso`: in the volume's numbers, inside is above. Results do not depend on the number of workers.
/// Throws InputError: iso not finite, step_mm not above 0, more voxels than VolumeLimits allows.
Volume interpolated_by_shape(const Volume& v, double iso, double step_mm, Workers& workers);

}  // namespace limberg
