#pragma once
// Checks between two versions of a lattice. Empty when all is well.
#include <string>

#include "sim/lattice/topology.h"
#include "tests/bench/fuzz/case.h"

namespace limberg::fuzz {

double body_volume_mm3(const BodySpec& spec);  // nearly: for tolerances

/// Every copy has a parent in its cell or in the one that it is a part of, every node
/// copy the state that its cells name; what hangs lies between its masters; the volume
/// of the children is that of the parent, or less when something was taken away.
std::string check_parents(const LatticeTopology& before, const LatticeTopology& after, bool only_cuts);

/// The same cells, classes, links and node copies, whatever their numbers.
std::string check_same(const LatticeTopology& updated, const LatticeTopology& built);

/// Lattice planes of `coarse` are among those of `fine` (half the pitch, same origin): what is one piece in a fine cell
/// is one piece in the coarse cell, and their volumes add up.
std::string check_refines(const LatticeTopology& coarse, const LatticeTopology& fine);

}  // namespace limberg::fuzz
