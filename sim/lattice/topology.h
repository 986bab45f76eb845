#pragma once
// Which copies of which cells and nodes exist: the virtual-node topology of the current material.
//
//   auto t0 = build_topology(grid, material_surface(arrangement));
//   arrangement.cut(...);
//   auto t1 = update_topology(t0, material_surface(arrangement));   // after every cut and every excision
//   undo: keep t0 and use it again (a topology never changes once made).
//
// A cell copy is one component of the material in one cell. Two copies in cells that share a square are joined, that is
// share its four nodes, when their material is connected through the square: when they hold the same sided face or the
// same corner of it (convexity makes this exact). A node copy is a class of (cell copy, corner) under this joining. The
// topology is a function of the surface alone; an update only avoids computing again what cannot have changed: cells in
// which no face has come, gone or lost material. Copies keep their order; new ones come after.
//
// Parents. Running the same components with both sides of every new wall united gives the classes of before, so each
// new class has one old class. The partition is a refinement: that all corners of a node copy agree on the parent is
// checked. When an excision is in the same update, the pieces that it leaves take the parent that their faces, corners
// or neighbours name.
//
// Fronts. A cut that ends inside a cell leaves it one copy: it opens only up to that cell. With
// front_levels = 3 a cell that holds a crack's front is divided in eight, and those of the
// eight that hold it again (cell_tree.h, division.cpp): then the closed part of the crack lies
// in one cell of a quarter of the size. Where the crack runs through that cell askew, farther
// than a quarter of the undivided cell from the front to where it comes in, it is divided a
// third time. Cells that touch each other, be it in a corner, differ by one level at most. The
// parts are cells like any other, found by the same exact method; between a part and a coarser
// neighbour the common square is the part's, and a node of it that is no corner of the
// neighbour hangs on the neighbour's copy. When it hangs on several copies, these share their
// nodes there (a cut may stay closed there for the length of a part, never is there a gap in
// tissue). Division never moves anything: every node of a part has its parents in the copy that
// was divided, with trilinear weights. Cells stay divided for the rest of the history (undo
// goes back to the version of that time). An update may divide nothing (Divide): where a pocket
// ends deep inside, nobody looks, and its long rim would cost most of the cells.
//
// Grading. grading.h names more cells to divide: those of a zone, be they cut or full, when the
// lattice is built; those at a wound with each cut. Division, levels that touch, what hangs and
// parents are the same as at fronts, whose levels count from the undivided cell here, too.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/base/parent_list.h"
#include "sim/base/short_lists.h"
#include "sim/base/workers.h"
#include "sim/lattice/cell_tree.h"
#include "sim/lattice/cells.h"
#include "sim/lattice/grading.h"
#include "sim/lattice/lattice.h"
#include "sim/lattice/link_table.h"
#include "sim/lattice/material_surface.h"

namespace limberg {

struct LatticeTopology {
  LatticeGrid grid;
  SharedArray<CellCopy> cells;
  SharedArray<NodeCopy> nodes;
  // Per copy: its index in the previous version, -1 only at the
  // start; of a born node (below) the one with the largest weight.
  ParentList cell_parent, node_parent;
  int pieces = 0;                        // connected pieces of the lattice
  std::vector<double> piece_volume_mm3;  // per piece
  std::vector<uint8_t> piece_fixed;      // per piece: 1 when it has a face of the body tagged fixed
  double volume_mm3 = 0;                 // sum over cell copies of fraction * cell volume
  std::vector<int128> piece_sum;  // per piece: sum of fractions of undivided cells, times 2^60; exact in any order
  uint64_t hash() const;          // of cells, classes, corners and node copies: no floating point, no parents. O(cells)

  int front_levels = 0;  // how often cells at a front are divided: 0 to kLevels
  Grading grading;       // which others are divided, and how often
  CellTree tree;
  bool divides() const { return front_levels > 0 || !grading.empty(); }  // its cells can be divided

  ShortLists copies;  // per cell (an id of the tree; a divided one has none) its cell copies, by class
  int copies_of(int32_t cell) const { return copies.count(size_t(cell)); }
  int32_t copy(int32_t cell, int cls) const { return copies.at(size_t(cell), cls); }

  /// Per cell: what it holds; null when no face meets it (it is full or empty then) or it is divided.
  SharedArray<std::shared_ptr<const CellComponents>> components;
  SharedArray<uint8_t> node_in_material;  // per lattice node

  uint8_t corners_in_material(int32_t cell) const;  // bit per corner

  LinkTable links;  // copies joined through squares

  struct Hanging {  // as HangingNode: equal weights, none of the masters hangs
    int32_t node = 0, count = 0;
    std::array<int32_t, 4> master{};
  };
  std::vector<Hanging> hanging;                   // ascending by node
  const Hanging* hanging_at(int32_t node) const;  // null: it does not hang
  struct Born {                                   // a node inside what was one cell in the previous version
    int32_t node = 0;
    std::vector<std::pair<int32_t, double>> from;  // previous nodes and weights
  };
  std::vector<Born> born;  // ascending by node

  SharedArray<uint8_t> face_bits;       // per face id: its material bits in this version (0: not there)
  int32_t operations = 0;               // of the surface so far (MaterialSurface::suspects)
  int32_t last_op = 0;                  // highest operation that has made a face so far
  int touched_cells = 0;                // recomputed to make this version
  int walks = 0, walks_unresolved = 0;  // sums over cells
};

/// Throws InputError when the surface reaches beyond the lattice, when the
/// grading is none, or when cells are to be divided and its pitch cannot be
/// halved kLevels times. Contradiction (contradiction.h): a surface whose
/// gluing contradicts its material bits.
std::shared_ptr<const LatticeTopology> build_topology(const LatticeGrid& grid, const MaterialSurface& surface,
                                                      int front_levels = 0, const Grading& grading = {});

/// The same with the cells divided that are divided in `like`, in the same order, and no others.
std::shared_ptr<const LatticeTopology> build_topology_like(const LatticeTopology& like, const MaterialSurface& surface);

/// What an update divides of the cells that it touches: those in which a front lies and those that the grading asks
/// for, or none.
enum class Divide : uint8_t { fronts, nothing };

/// The version after the arrangement has changed. cell_parent and node_parent index `previous`.
/// Face ids must mean the same as in `previous` (an arrangement never renumbers; after its undo, go on from the version
/// of that time). Nothing changes on an exception.
/// Cells are found in parallel when there are workers; the result does not depend on them.
std::shared_ptr<const LatticeTopology> update_topology(const LatticeTopology& previous, const MaterialSurface& surface,
                                                       Workers* workers = nullptr, Divide divide = Divide::fronts);

/// `last` with the parents of the version before `middle`, which `last` was updated from. A cut that takes something
/// away at once is followed in two steps, the cut and the taking away: each names its parents exactly.
std::shared_ptr<const LatticeTopology> skip_version(const LatticeTopology& middle, const LatticeTopology& last);

/// Empty when every invariant holds: corner states along all lattice edges, links symmetric with shared nodes, classes
/// numbered without gaps, levels graded, hanging nodes between their masters. O(cells), for tests.
std::string check_topology(const LatticeTopology& topology);

}  // namespace limberg
