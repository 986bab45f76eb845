#pragma once
// Getting a volume ready for a fit: what is the object, where is its outside, and where does it leave the picture.
//
//   smoothed    a Gaussian takes noise off (separable, along the voxel axes)
//   object      the largest part (6-connected nodes) above the isovalue,
//               or the largest ones: table, head rest and specks go
//   lids        where the object leaves the volume it is closed by a
//               lid on the border, so that an open vault is no way in
//   sealed      air is what a ball of radius `seal_mm` reaches from outside;
//               airway, sinuses, inner table, cranial cavity and openings narrower
//               than the ball are not (closing by a ball: dilate, then erode)
//
//   cavities    with `mouth_mm`: orbits, nose and foramen are entered by that
//               ball, but not by a wider one, and go on behind their mouths:
//              they are closed there (mouths.h). With `thin` bone that voxels have blurred
//              below the isovalue (thin_walls.h) is in the way too: else temples and
//              sinuses, whose walls an isosurface lacks, are entered and taken for cavities
//
// The result is a guide: the signed distance to the sealed surface on an even grid.
// A mesh led by it goes to the outer surface and nowhere else; where that surface
// is a lid or spans an opening there is no isosurface, and the mesh is opened
// there; on a thin wall there is none either, and it stays closed. Places on
// the isosurface that belong to the sealed surface are kept, to tell afterwards how much of it a mesh has reached.
//
// Distances on the grid: exact Euclidean transform by lower
// envelopes of parabolas (Felzenszwalb and Huttenlocher 2012).
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/base/workers.h"
#include "sim/imaging/io/volume.h"

namespace limberg {

struct PrepareSettings {
  double iso = 0;
  double sigma_voxels = 0.6;  // of the Gaussian, in voxels along each axis; 0: none
  double seal_mm = 6;         // 0: every way in that voxels leave open is gone
  // > seal_mm: cavities that a ball of this radius does not enter,
  // and that are deeper than wide, are closed at their mouths
  double mouth_mm = 0;
  double mouth_depth_mm = 6;   // hollows less deep are no cavities
  double mouth_width_mm = 18;  // nor are passages less wide, nor wider than 2.5 mouth_mm
  std::optional<double> thin;  // below iso, with mouth_mm: crests above this value are thin walls
  // no place of one is farther from the object, and a ball of this radius does not pass through the gap
  double thin_mm = 12;
  double least_part = 1;            // parts are kept that have at least this share of the largest one's nodes
  int64_t guide_nodes = 4'000'000;  // at most about so many; the grid is coarser where more would be needed
};

/// The way into a cavity that is closed for the guide, and opened in the mesh.
struct CavityMouth {
  Vec3 centre_mm = Vec3::Zero();
  double width_mm = 0, depth_mm = 0;  // of the disc that is as large as its throat; of what lies behind
};

struct Prepared {
  Volume volume;  // smoothed; what the isosurface is taken from
  Volume guide;   // mm to the sealed surface, > 0 outside; reaches beyond the volume on all sides
  double iso = 0;
  double voxel_mm = 1;                                 // smallest side of a voxel
  double guide_mm = 1;                                 // step of the guide
  double seal_mm = 0, mouth_mm = 0;                    // mouth_mm 0: cavities were not looked for
  Vec3 low_mm = Vec3::Zero(), high_mm = Vec3::Zero();  // box of the object, along the axes of the frame
  int64_t object_nodes = 0;                            // of the guide's grid
  int64_t dropped_nodes = 0;                           // above the isovalue, but in other parts
  int parts = 0, kept_parts = 0;
  std::vector<CavityMouth> mouth;  // widest first
  std::vector<uint8_t> gate;     // of the guide's nodes: 1 about the mouths of cavities that are closed; empty: none is
  std::vector<Vec3> wall_mm;     // on thin walls where they are the sealed surface: their crests
  std::vector<Vec3> surface_mm;  // on the isosurface where it is the sealed surface, in the order of the voxels
};

/// Throws InputError: settings that are not finite, nothing above the isovalue (with the range of the volume), or
/// everything.
Prepared prepare(const Volume& volume, const PrepareSettings& settings, Workers& workers);

/// Gaussian with that standard deviation in voxels along each axis; the border is held on.
Volume smoothed(const Volume& volume, double sigma_voxels, Workers& workers);

/// Squared distance of every node of an even grid to the nearest node that is set, in steps; infinite when none is.
std::vector<float> squared_distance(const std::array<int32_t, 3>& size, const std::vector<uint8_t>& set,
                                    Workers& workers);

}  // namespace limberg
