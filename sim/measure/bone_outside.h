#pragma once
// Bone that stands out of the skin of a head: places of the bones in front of the face's surface.
//
// The face is the skin's outer surface, and may end somewhere: a place counts where the nearest point of the face is
// not on its border, on the outer side of the face there (angle-weighted normals, as Skin::depth_mm). What was outside
// before the operation (a scan that leaves part of the head out) is no fault of it and does not count.
#include "sim/patient/snapshot.h"

namespace limberg {

struct BoneOutside {
  double depth_mm = 0;        // of the place that stands out farthest
  double area_mm2 = 0;        // of bone that stands out
  Vec3 at_mm = Vec3::Zero();  // that place, now
  int32_t object = -1;        // number of its fragment
};

/// Nothing where there is no face or no bone. About 0.1 s on 20,000 places.
BoneOutside bone_outside(const Snapshot& snapshot);

}  // namespace limberg
