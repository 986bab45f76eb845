#pragma once
// In which ways one cut ring may lie along another one.
//
// A way is found from a run of kHalf_mm to either side of a place on each ring, walked in opposite directions: the
// rigid motion with the least sum of squares between the two runs, place by place along the arc (Kabsch), the surface's
// normals included as places kArm_mm over the ring. So single corners do not count for much, and rings that were
// divided into edges differently are the same. All cyclic shifts of one ring against the other are tried; runs whose
// chords differ by more than their noise
// explains are passed over at once. From the run on the rings are followed both ways as long as they stay together:
// parts of rings are enough.
#include <vector>

#include "sim/geometry/rotation.h"
#include "sim/skull/bone/rings.h"

namespace limberg::bone {

struct RingWay {
  double score = 0;                                     // mm of ring that stay together, the nearer the more
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();  // of q onto p
};

/// By how many degrees a placement turns.
inline double degrees(const Eigen::Isometry3d& T) { return axis_angle(T.linear()).angle * kDeg; }

/// The best ways for every second place of p, best first; at most `most`, all different by more than 4 mm or 8 degrees
/// at `about` (a place near q).
std::vector<RingWay> ring_ways(const Ring& p, const Ring& q, const Vec3& about, size_t most);

inline constexpr double kHalf_mm = 12, kArm_mm = 4;

}  // namespace limberg::bone
