#pragma once
// Where a lattice is fine: how often each of its cells is to be divided.
//
//   zone          a stretch of tissue and a radius around it: cells that reach into it have at least its level
//   wound_level   cells that a blade has cut through have at least this level, and so have all that touch them: the
//                 fine part follows the wound as it grows
//
// Level k is 1 / 2^k of an undivided cell's edge. Both say what a cell needs by itself; topology.h adds what its
// neighbours need (touching cells differ by one level at most) and what fronts ask for beside. So the divisions are a
// function of the surface and the grading, whatever the order in which cells are looked at.
//
// Cells reach into a zone with what is left of them when a sixteenth is taken off each side: where a zone ends on a
// plane of the lattice, rounding must not decide about a row of cells.
#include <cstdint>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// All within the radius of a straight stretch, but for what lies deeper than depth_mm below its first end.
struct GradedZone {
  Vec3 from_mm = Vec3::Zero(), to_mm = Vec3::Zero();  // equal: a place
  Vec3 inward = -Vec3::UnitZ();                       // unit, into the body
  double radius_mm = 0;
  double depth_mm = 0;  // infinite: no limit
  int level = 0;
  bool operator==(const GradedZone&) const = default;
};

struct Grading {
  std::vector<GradedZone> zones;
  int wound_level = 0;  // 0: wounds divide nothing
  bool empty() const { return zones.empty() && wound_level == 0; }
  bool operator==(const Grading&) const = default;
};

/// The highest level of the zones that a cell reaches into; 0: of none.
int zone_level(const Grading& grading, const Vec3& low_mm, const Vec3& high_mm);

/// Throws InputError when a zone is none, or a level is not from 0 to kLevels.
void check_grading(const Grading& grading);

}  // namespace limberg
