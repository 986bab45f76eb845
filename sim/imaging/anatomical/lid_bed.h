#pragma once
// What parted lids lie against: the globe of the right eye (Eye::globe_mm). It does not move.
#include "sim/geometry/tri_mesh.h"

namespace limberg {

/// Closed surfaces of the globe, mm; without tags. Iris and pupil are caps that lie upon the globe, each a little over
/// what is beneath, so that they are seen.
struct LidBedMeshes {
  TriMesh globe, iris, pupil;
};
LidBedMeshes make_lid_bed();

}  // namespace limberg
