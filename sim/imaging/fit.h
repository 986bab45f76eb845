#pragma once
// A simplex mesh deformed to an isosurface of a volume: skin or bone from a CT.
//
// Every vertex looks along its normal, both ways, for the nearest place where the volume falls through the isovalue going outwards,
// and is pulled there along the normal. The mesh begins stiff and far-sighted and ends supple and near-sighted: rigidity 8 to 1, weight
// of the data 0.05 to 0.5, range from `range_mm` to two voxels; between the stages its faces are adapted. At the end faces
// whose vertices have found nothing are opened as end contours, where they make up regions that can be opened.
#include <functional>
#include <string>
#include <vector>

#include "sim/imaging/volume.h"
#include "sim/simplex/mesh.h"
#include "sim/workers.h"

namespace limberg {

struct FitSettings {
  double iso = 0;                 // in the numbers of the volume; inside is above
  double range_mm = 30;           // how far vertices look at first
  double edge_mm = 4;             // wanted edges at the end
  double chord_mm = 0;            // > 0: shorter edges where the surface is curved (adapt.h)
  int stages = 8;                 // of `iterations` each
  int iterations = 50;
  double still_mm = 0.01;         // a stage ends when nothing moves farther, ten times in a row
  bool open_ends = true;
  std::function<void(int stage, int32_t vertices, double max_move_mm)> progress;  // may be empty
};

struct FitReport {
  int iterations = 0;
  int32_t vertices = 0;
  double found = 0;               // part of the vertices that have an edge within two voxels
  double rms_mm = 0, p95_mm = 0, max_mm = 0;  // distance of those to the isosurface, |I - iso| / |grad I|
  int holes = 0;                  // opened
  int64_t vertex_iterations = 0;
};

/// Throws InputError on settings that are not finite or positive.
FitReport fit(simplex::Mesh& mesh, const Volume& volume, const FitSettings& settings, Workers& workers);

}  // namespace limberg
