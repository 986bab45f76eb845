#pragma once
// Thin walls of bone that a CT has lost.
//
// A wall that is thinner than the scanner resolves comes out blurred: in a voxel of 3 mm half a millimetre of cortical
// bone lifts the value by some
// 150 HU only, and an isosurface has a hole there (fenestrations, dehiscences). Yet the blurred wall is still a crest:
// a sheet on which the value is largest across it. So beside the isovalue a lower threshold is used, where such a crest
// is and nowhere else (a sheet by the eigenvalues of
// the Hessian: Sato 2000, Descoteaux 2006; which nodes it passes
// through: Steger 1998), and of it what goes on from the object.
#include <cstdint>
#include <vector>

#include "sim/imaging/fit/grid_reach.h"
#include "sim/imaging/io/volume.h"

namespace limberg::imaging {

struct WallRule {
  double above = 0;   // what a crest's value must be
  double air = 0;     // a sheet with less than this on both sides is a septum in a cavity, and none of its walls
  double beside = 2;  // steps: so far from the crest
  double blur = 1;    // steps: scale of the derivatives
  double across = 6;  // steps: no place of a wall is farther from the object
};

/// Nodes of `values` (an even grid) on crests that go on from what is `set`, as they are reached from there; only nodes
/// that `may`.
std::vector<size_t> thin_walls(const Volume& values, const std::vector<uint8_t>& set, const std::vector<uint8_t>& may,
                               const WallRule& rule, Workers& workers);

/// Whether the crest of a sheet passes by node `i` of `blurred` (an even grid; not at its border); `across`: its
/// normal, along the axes of the grid.
bool crest_passes(const Volume& blurred, size_t i, Vec3& across);

}  // namespace limberg::imaging
