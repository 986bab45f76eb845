#pragma once
// What one lattice cell holds: the connected components ("classes") of the material in it, found exactly.
//
// Method. A triangle meets a box in a convex set, so the sided faces of the cell are joined along glued edges that meet
// the box; lattice edges join what they run through; closed curves on the six squares and closed shells inside are
// joined to what surrounds them by a walk along an axis (cells_walk.cpp). Two sided faces are in the same class exactly
// if the material between them is connected inside the cell. Faces on a lattice plane, edges through a lattice edge and
// the like cannot happen: every test is made with the lattice shifted by (-e1, -e2, -e3), e1 >> e2 >> e3 > 0 vanishing
// (lattice_signs.h). A line of the lattice is walked with the two material bits of what it hits; that the state equals
// the bits at every hit is asserted.
#include <memory>
#include <vector>

#include "sim/lattice/lattice.h"
#include "sim/lattice/material_surface.h"

namespace limberg {

struct CellClass {
  double fraction = 0;  // volume of the material / volume of the cell
  uint8_t corners = 0;  // bit per corner of the cell that lies in it
  // bit 2 axis + (0 low, 1 high): it has a `fixed` face whose outward normal is mostly along it
  uint8_t fixed_sides = 0;
  int16_t old_class = -1;  // class of the cell's previous version that it is a part of (-1: there was none)
};

/// Immutable; shared by all versions of the topology in which the cell is the same.
struct CellComponents {
  std::vector<int32_t> face;                    // faces that meet the cell, ascending
  std::vector<std::array<int16_t, 2>> of_side;  // per face and side: its class, -1 without material
  std::vector<uint64_t> relation;  // per face: how it lies in the cell, all of it exact (FaceInCell); never changes
  std::vector<double>
      flux;  // per face: its share of a volume (cell_volume.cpp), which never changes; NaN: not asked for yet
  std::array<int16_t, 8> of_corner{};  // class of each corner, -1 outside
  std::vector<CellClass> classes;
  // Per lattice edge of the cell (4 * axis + 2 * [third axis high] + [second axis high], the axes in cyclic order after
  // `axis`): 0 = nothing crosses it; else 4 | material at the low end | 2 * material at the high end.
  std::array<uint8_t, 12> edge_state{};
  int walks = 0;             // closed curves and shells that were followed to what surrounds them
  int walks_unresolved = 0;  // closed curves too small for a walk to start on (below 2^-24 half-units)

  /// Class of a sided face, -1 when the face is not in the cell or has no material on that side.
  int class_of(int32_t sided_face) const;
};

}  // namespace limberg
