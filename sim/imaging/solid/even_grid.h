#pragma once
// An even grid around a volume, its axes those of the voxels (made orthogonal, which they nearly always are), and sets
// of its nodes.
#include <cstdint>
#include <vector>

#include "sim/base/workers.h"
#include "sim/imaging/fit/grid_reach.h"
#include "sim/imaging/io/volume.h"

namespace limberg::imaging {

/// The box of a volume's voxel centres along its own axes (columns of `axes`, orthonormal).
struct VoxelBox {
  Mat3 axes = Mat3::Identity();
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // along the axes, mm
};
VoxelBox voxel_box(const Volume& volume);

/// Steps of `step_mm`; `pad` nodes beyond the volume on every side; no values yet. `first`, `last`: the outermost nodes
/// that lie within the volume.
struct EvenGrid {
  Volume nodes;
  double step_mm = 1;
  GridSize first{}, last{};
  bool within(const std::array<int32_t, 3>& at) const {
    for (size_t k = 0; k < 3; ++k)
      if (at[k] < first[k] || at[k] > last[k]) return false;
    return true;
  }
};
/// The step is lengthened until there are at most `most_nodes`.
EvenGrid even_grid(const Volume& volume, double step_mm, int32_t pad, int64_t most_nodes);

/// Values of `volume` at the nodes; `beyond` outside it.
std::vector<float> sampled(const Volume& volume, const EvenGrid& grid, float beyond, Workers& workers);

/// The 6-connected parts of what is set: for each node its part, -1 where it is not set; and the nodes of each part.
struct GridParts {
  std::vector<int32_t> of;
  std::vector<int64_t> nodes;
};
GridParts parts_of(const GridSize& size, const std::vector<uint8_t>& set);

}  // namespace limberg::imaging
