#pragma once
// `limberg bench cutting`: what a cut costs, in CPU time of this process, on one core (but for what is said to be by
// the clock).
//
//   arrangement  a 200-triangle blade, 120 mm long and 9 mm deep, into the skin of slabs
//                of 26 k to 1.6 M triangles (cutting_scene.h), against CGAL's corefinement
//                of the same two meshes, taking turns in the same run (cgal_child.h)
//   growth       our time at 1.6 M triangles over that at 103 k
//   history      one cut in the fresh slab and again after 199 others; and the last 20 of 200 cuts against the first 20
//   crossing     the second, third and fourth cut, across earlier ones, against the first (cutting_crossing.cpp)
//   whole cut    from the blade to the new topology at 103 k triangles and cells of 3
//                mm: arrangement, lattice, finite elements, surface that is drawn; and
//                what the solver then does with the model, which has bars of its own
//   fronts       where a slit that ends inside lattice cells really opens, with and without divided cells (fronts.h)
//   drawn        an incision of 91 mm that is drawn live on a face (cutting_drawn.cpp), by the clock
//   memory       of the arrangement, per triangle
//
// What is fair and what is not: ours keeps a box tree over the triangles of the body from cut
// to cut, and CGAL makes its own in every call; the time of building ours is a row. Ours also
// glues the two banks, keeps what undo needs, and checks that volume and closure are kept;
// CGAL only adds the curve to both meshes. Both work on the same even-grid coordinates.
#include <functional>
#include <string>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct CuttingSettings {
  bool quick = false;  // small slabs, few repeats: behaviour, not time; the bars that need size are left out
  /// Parts whose name contains this: arrangement, history, crossing, whole cut, fronts, drawn; empty: all.
  std::string only;
  std::string cgal_program;                          // empty: the helper beside the running program
  std::function<void(const std::string&)> progress;  // empty: silent
};

Result cutting(const CuttingSettings& settings);

/// The parts "crossing" (cutting_crossing.cpp) and "whole cut" (cutting_whole.cpp).
void crossing_cuts(Result& out, const CuttingSettings& settings, int slab_cells, int repeats);
void whole_cut(Result& out, const CuttingSettings& settings, int slab_cells, double cell_mm, int repeats);
/// The part "drawn" (cutting_drawn.cpp).
void drawn_incision(Result& out, const CuttingSettings& settings);

}  // namespace limberg::bench
