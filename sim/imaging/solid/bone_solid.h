#pragma once
// Bone of a CT as a solid: with an outer and an inner table, its cavities, and walls thinner than a voxel.
//
//   object      what lies above the isovalue within the body: table, head rest and specks go. The body is the largest
//               part of what is denser than air
//   walls       crests below the isovalue that go on from bone (fit/thin_walls.h), each as thick as its blurred density
//               says (wall_sheets.h)
//   cavities    what bone encloses on all sides. Diploe, marrow and specks are filled: those that are small, or so
//               narrow that no ball of `narrow_mm` finds room. The others (sinuses) stay hollow, and a passage of
//               `passage_mm` is drilled from each along the way that costs the least bone, as nature's ostia do: so
//               bone is bounded by one closed surface
//   borders     where bone leaves the volume it ends there, in a flat face
//
// The result is a distance, below 0 in bone, on an even grid; near the surface it is that of the isovalue to well below
// a voxel, (iso - I) / |grad I|. What is thinner than the grid can hold is drawn as thick as that, and said.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/imaging/fit/level_set.h"
#include "sim/imaging/io/volume.h"

namespace limberg {

struct BoneSolidSettings {
  double iso = 250;             // in the numbers of the volume
  double body = -300;           // above it is the body
  double sigma_voxels = 0.6;    // of the Gaussian that takes noise off
  std::optional<double> thin;   // crests above this value, below iso, are thin walls
  double thin_across_mm = 12;   // no place of one is farther from what lies above the isovalue
  double least_part_mm3 = 500;  // smaller pieces of bone are dropped
  double least_cavity_mm3 = 500, narrow_mm = 2;
  double passage_mm = 3;  // width of what opens a cavity
  double step_mm = 0;     // of the grid; 0: the smallest side of a voxel, at least 0.8
  int64_t most_nodes = 16'000'000;
};

struct BoneCavity {
  Vec3 centre_mm = Vec3::Zero();
  double volume_mm3 = 0;
  double widest_mm = 0;  // of the largest ball that finds room
};

struct BoneSolid {
  Volume distance;           // mm
  std::vector<float> value;  // of the smoothed volume at the nodes of `distance`
  double step_mm = 1;
  double cortical = 0;  // density that thin walls were measured with
  double volume_cm3 = 0;
  int pieces = 0, dropped = 0;  // kept; too small, or outside the body
  double dropped_mm3 = 0;
  double filled_mm3 = 0;           // diploe and specks
  std::vector<BoneCavity> cavity;  // that stay hollow, largest first
  double thin_mm2 = 0;             // area of walls that only their crests show
  double thin_median_mm = 0;       // of their thickness
  double as_mm = 0;                // what is thinner is drawn so thick,
  double drawn_thicker = 0;        // which is this share of them
};

/// Throws InputError: settings that make no sense, nothing above the isovalue (with the range of the volume).
BoneSolid bone_solid(const Volume& volume, const BoneSolidSettings& settings, Workers& workers);

/// What `level_set.h` makes a mesh of. The solid must outlive it.
LevelSet surface_of(const BoneSolid& solid);

}  // namespace limberg
