#pragma once
// A generated patient: a flat block of skin on softer layers.
//
// The block fills [-sx/2, sx/2] x [-sy/2, sy/2] x [-sz, 0] mm. Its top, z = 0, is the skin: a
// grid of nearly square cells of skin_cell_mm, each split along a diagonal that alternates like
// a chessboard, so that no direction is favoured. Sides and bottom are tagged fixed where they hold the block, whole
// or sliding in their plane (rollers, a plane of symmetry), else free. The bottom grid is twice as coarse; the lowest
// row of the sides makes the change, so that the surface is closed without T-junctions. All vertices lie on the even
// rest grid and every side is exactly flat. uv runs from 0 to 1 over the longer side of the skin and unfolds over the
// edges.
#include <array>
#include <string>
#include <vector>

#include "sim/body/body.h"

namespace limberg {

/// What a side of a block does to the tissue at it.
enum class SideHold : uint8_t { held, sliding, free };

struct BlockSpec {
  std::string name = "block";
  Vec3 size_mm{120, 120, 10};
  double skin_cell_mm = 0.8;
  std::vector<Layer> layers;  // from the skin down; empty: one layer of the default material
  Vec3 tension_direction = Vec3::UnitX();
  std::array<SideHold, 5> sides{};  // -x, +x, -y, +y, -z; the skin, +z, is always free
};

/// Throws InputError (file = spec.name, line 0) on sizes that are not finite and positive, larger than 1000 mm or finer
/// than the limit of 4 million triangles.
Body make_block(const BlockSpec& spec);

/// The finest power of two, at most 1/8192 mm, with which a body of this half extent (mm, from the grid's origin) and a
/// margin of 1/32 around it fit the rest grid.
double rest_unit_mm(double half_extent_mm);

}  // namespace limberg
