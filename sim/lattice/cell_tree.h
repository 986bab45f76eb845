#pragma once
// Which cells of the lattice are divided, and where their parts lie.
//
// Ids: the cells of the grid first, by their index; then the parts, eight by eight
// in the order of division (part k has the bits of its corner: 1 = +x, 2 = +y, 4 =
// +z). A tree only grows, so an id means the same cell in every later version.
#include <array>
#include <cstdint>
#include <utility>

#include "sim/base/shared_array.h"
#include "sim/lattice/lattice.h"

namespace limberg {

struct CellPlace {
  int level = 0;
  Int3 at{};  // cell of the grid of that level
};

struct CellTree {
  struct Division {
    int32_t cell = 0;
    // Which of the 27 corners of the parts (x fastest) lie in the material.
    std::array<uint8_t, 27> node_in_material{};
    bool operator==(const Division&) const = default;
  };
  int32_t grid_cells = 0;
  SharedArray<Division> division;
  SharedArray<int32_t> division_of;  // per id; empty as long as nothing is divided; -1: not divided

  int32_t ids() const { return grid_cells + 8 * int32_t(division.size()); }
  bool is_divided(int32_t cell) const { return !division_of.empty() && division_of[size_t(cell)] >= 0; }
  int32_t part(int32_t cell, int k) const { return grid_cells + 8 * division_of[size_t(cell)] + k; }
  bool is_part(int32_t cell) const { return cell >= grid_cells; }
  const Division& division_with(int32_t part) const { return division[size_t(part - grid_cells) / 8]; }
  int32_t owner(int32_t part) const { return division_with(part).cell; }
  static int bits(int k, int axis) { return k >> axis & 1; }
  int which_part(int32_t part) const { return (part - grid_cells) % 8; }

  /// Makes the eight parts; returns the number of the division.
  int32_t divide(int32_t cell) {
    division_of.resize(size_t(ids()), -1);
    const int32_t made = int32_t(division.size());
    division_of[size_t(cell)] = made;
    division.push_back({cell, {}});
    division_of.resize(size_t(ids()), -1);
    return made;
  }

  CellPlace place(const LatticeGrid& grid, int32_t cell) const {
    if (!is_part(cell)) return {0, grid.cell_at(cell)};
    CellPlace p = place(grid, owner(cell));
    const int k = which_part(cell);
    return {p.level + 1, {2 * p.at.x + bits(k, 0), 2 * p.at.y + bits(k, 1), 2 * p.at.z + bits(k, 2)}};
  }
  int level(int32_t cell) const { return is_part(cell) ? level(owner(cell)) + 1 : 0; }

  /// The cell of that level at `at` (inside the grid), divided or not; or the undivided coarser one that holds it.
  int32_t find(const LatticeGrid& grid, int level, Int3 at) const {
    int32_t cell = grid.cell_index({at.x >> level, at.y >> level, at.z >> level});
    for (int l = level - 1; l >= 0 && is_divided(cell); --l)
      cell = part(cell, (at.x >> l & 1) | (at.y >> l & 1) << 1 | (at.z >> l & 1) << 2);
    return cell;
  }
};

}  // namespace limberg
