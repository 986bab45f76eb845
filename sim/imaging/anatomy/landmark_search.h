#pragma once
// A landmark sought on a surface by the rule that defines it (synthetic_head.h: landmark_rules), near a first place.
//
//   profile     a rule that looks along one line: its highest place with lower ones on both sides (a deepest place is
//               one along the other direction), then the top of a parabola through what lies around it
//   area        its farthest place, then the middle of what is level with it
//   none        where the profile only rises towards an end of the window, or the farthest place lies at its border,
//               the top is elsewhere: the first place is taken, and may be as far off as the window is wide
#include <Eigen/Geometry>
#include <optional>

#include "sim/geometry/bvh.h"
#include "sim/imaging/synthetic/synthetic_head.h"

namespace limberg {

struct SoughtLandmark {
  std::optional<Vec3> at_mm;  // in the frame of the head; nothing: there is no surface
  double flat_mm = 0;         // so far it may lie from its place without that being seen
  bool as_laid = false;       // the first place, brought to the surface
};

struct LandmarkSearch {
  static constexpr double kReach_mm = 15;  // the surface so near a first place is meant where no ray meets it

  const Bvh& surface;
  const Eigen::Isometry3d& to_head;  // from the frame of the surface
  double voxel_mm;                   // of the picture that it was taken from

  /// By the rule of a landmark of that side (1 right, -1 left; mirrored), near `place` in the frame of the head.
  SoughtLandmark by_rule(const LandmarkRule& rule, const Vec3& place_mm, double side) const;
  /// Where `place` itself comes to lie on the surface.
  SoughtLandmark as_laid(const LandmarkRule& rule, const Vec3& place_mm, double side) const;
};

}  // namespace limberg
