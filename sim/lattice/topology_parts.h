#pragma once
// The parts that topology.cpp is put together from.
#include "sim/lattice/cell_builder.h"
#include "sim/lattice/topology.h"

namespace limberg {

/// Which lattice nodes lie in the material: every lattice line along x is walked through all that it hits. Throws
/// InputError when the surface reaches beyond the lattice.
std::vector<uint8_t> classify_nodes(const LatticeGrid& grid, const MaterialSurface& surface);

/// Numbers the cell copies (kept ones in the order of `previous`, new ones after, by cell and class) and names parents.
void number_copies(LatticeTopology& topology, const LatticeTopology* previous, std::span<const uint8_t> touched);

/// Links between `cell` and its + neighbour along `axis`.
void find_links(const LatticeTopology& topology, int32_t cell, int axis, std::vector<LatticeTopology::Link>& out);

/// Parents of copies that nothing in their own cell could name, by their neighbours.
void name_parents_by_neighbours(LatticeTopology& topology, const LatticeTopology& previous);

/// Node copies from links: ids of kept ones follow their parents' order. Throws std::logic_error when corners that are
/// one node now were several before.
void number_nodes(LatticeTopology& topology, const LatticeTopology* previous);

/// Pieces, volumes and the hash.
void summarise(LatticeTopology& topology);

}  // namespace limberg
