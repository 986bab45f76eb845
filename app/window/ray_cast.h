#pragma once
// Which point of the patient lies under the mouse.
#include "sim/patient/snapshot.h"

namespace limberg {

struct RayHit {
  int32_t triangle = -1;  // of the view; -1: nothing
  Vec3f bary = Vec3f::Zero();
  Vec3f x_mm = Vec3f::Zero(), normal = Vec3f::UnitZ();  // deformed; the normal is turned towards the ray's origin
  float distance_mm = 0;
};

/// The first triangle that the ray meets (Moeller and Trumbore 1997); one pass over all of them: .1 ms for 30,000
/// (measured 2026-11-21). `towards` is a unit vector. Allocates nothing.
RayHit cast_ray(const Snapshot& snapshot, const Vec3f& origin_mm, const Vec3f& towards, bool bone_only = false);

}  // namespace limberg
