#pragma once
// The embedding lattice and its copies.
//
// A LatticeGrid is a box of equal cells on odd coordinates of the rest grid. Cells at the end of a cut may be divided
// in eight, and the parts again (cell_tree.h); the parts are cells of a finer grid over the same box, so all that is
// said of cells holds for them. A LatticeTopology says which copies of
// which cells exist: one copy per connected piece of material in a cell (the virtual node algorithm), found exactly by
// cells.h. Cutting only refines the partition, so every copy has one parent in the version before
// (LatticeTopology::cell_parent, node_parent).
#include <cstdint>
#include <vector>

#include "sim/body/body.h"
#include "sim/fem/model/fem_model.h"

namespace limberg {

/// Plane i of an axis lies at origin + i * pitch half-units: origin odd, pitch even.
struct LatticeGrid {
  RestGrid rest;
  Int3 origin{};
  Int3 pitch{};  // half-units, per axis (a block's lattice is fitted to it; otherwise cubic)
  Int3 count{};  // cells per axis

  int32_t cell_index(Int3 c) const { return (c.z * count.y + c.y) * count.x + c.x; }
  Int3 cell_at(int32_t i) const { return {i % count.x, i / count.x % count.y, i / (count.x * count.y)}; }
  int32_t node_index(Int3 n) const { return (n.z * (count.y + 1) + n.y) * (count.x + 1) + n.x; }
  Int3 node_at(int32_t i) const {
    return {i % (count.x + 1), i / (count.x + 1) % (count.y + 1), i / ((count.x + 1) * (count.y + 1))};
  }
  Vec3 node_mm(Int3 n) const {
    return rest.to_mm({origin.x + n.x * pitch.x, origin.y + n.y * pitch.y, origin.z + n.z * pitch.z});
  }
  /// Place given in eighths of a cell (whole cells when the pitch is not divisible).
  Vec3 eighth_mm(Int3 q) const {
    return rest.to_mm(
        {origin.x + q.x * (pitch.x / 2) / 4, origin.y + q.y * (pitch.y / 2) / 4, origin.z + q.z * (pitch.z / 2) / 4});
  }
  Vec3 cell_mm() const { return rest.half_unit_mm() * Vec3(pitch.x, pitch.y, pitch.z); }
  /// The grid of the parts of cells divided `level` times. Its pitch must stay even: see divisible().
  LatticeGrid at_level(int level) const {
    LatticeGrid g = *this;
    g.pitch = {pitch.x >> level, pitch.y >> level, pitch.z >> level};
    g.count = {count.x << level, count.y << level, count.z << level};
    return g;
  }
  bool divisible(int levels) const {
    const int32_t unit = 2 << levels;
    return pitch.x % unit == 0 && pitch.y % unit == 0 && pitch.z % unit == 0;
  }
};

/// Cells are divided so often at most.
inline constexpr int kLevels = 3;
/// Places of nodes are counted in eighths of an undivided cell.
inline constexpr int kEighths = 1 << kLevels;

struct CellCopy {
  int32_t cell = 0;     // cell id: the lattice cell's index; from the number of cells on, parts of divided ones
  int32_t piece = 0;    // connected piece of the whole lattice (0..pieces-1)
  double fraction = 1;  // exact volume of its material / volume of the cell
  std::array<int32_t, 8> node{};  // node copies, corner order of fem_model.h
  bool operator==(const CellCopy&) const = default;
};

struct NodeCopy {
  int32_t lattice_node = 0;  // -1: a corner of parts of cells only
  Int3 at{};                 // eighths of an undivided cell from the grid's origin
  bool operator==(const NodeCopy&) const = default;
};

}  // namespace limberg
