#pragma once
// Energy and gradient of all cells: the one loop that visits the material.
//
// Works on displacements u = x - X, so that a flat, unloaded state is exactly zero and single precision keeps its digits:
// with K the stencil, B_a = grad N_a at its sample point, G = sum u_a B_a^T, F = I + G,
//
//   f_a = scale * ( sum_b K_ab u_b + f0_a + V ( (p - p0)(cof F - I) + p I ) B_a ),   f0_a = (K X)_a - p0 V B_a
//   p   = ke (theta + q),  theta = J - 1
//
// Augmented Lagrangian with the pressure eliminated per cell: q is the stored multiplier over the penalty k = 3 mu,
// ke = lambda k / (lambda + k). At the fixed point of update_multipliers p = lambda theta, so the answer is that of the
// plain energy; the minimiser only ever meets the stiffness ke. Cells with lambda below `primal_below` mu (nu < 0.4) keep
// q = 0 and ke = lambda.
//
// Cells are kept in tiles of the lattice. A tile gathers its nodes into a small local array, works there, and leaves its
// forces in slots of its own; slots are summed per node in tile order. So the result has the same bits for any number of
// workers.
#include <vector>

#include "sim/fem/simd.h"

namespace limberg::fem {

/// One stencil as the kernel wants it.
struct alignas(64) KernelStencil {
  float K[64];      // column b at K[8 b ...]
  float f0[32];     // 8 nodes of 4
  float volume = 0; // mm^3
  float p0 = 0;     // kPa
  float ke = 0;     // kPa, effective bulk stiffness
  float r = 0;      // lambda / (lambda + k); 0: no multiplier
  // Sample gradients off the centre: per axis, of the four cell edges along it, in corner order (1 / mm).
  float bx[4], by[4], bz[4];
  bool centred = true;
  float inv4h[3] = {0, 0, 0};  // 1 / (4 edge), of the cells of its level
};

struct KernelCell {
  uint16_t node[8];  // in the tile's local list
  int32_t stencil = 0;
  float scale = 0;
};

struct Tile {
  int32_t first_cell = 0, last_cell = 0;
  int32_t first_slot = 0, last_slot = 0;
};

struct CellSums {
  double energy = 0;     // uJ, relative to the undeformed state
  double magnitude = 0;  // sum of |terms|: its rounding unit is the noise of `energy`
};

/// Everything the kernel reads; filled by ElementSystem.
struct KernelData {
  AlignedArray<KernelStencil> stencils;
  AlignedArray<KernelCell> cells;  // in tile order
  std::vector<Tile> tiles;
  std::vector<int32_t> slot_node;
  std::vector<int32_t> node_slots_begin, node_slots;  // per node: its slots in ascending order
};

/// One tile: reads u, q; writes the tile's slots and theta. With `measure` the w of a slot is the sum of the norms of the
/// cell forces there.
CellSums evaluate_tile(const KernelData& data, const Tile& tile, const NodeArray& u, const float* q, Node4* slots,
                       float* theta, bool measure);

/// Sums slots into nodes [begin, end).
void sum_slots(const KernelData& data, const Node4* slots, size_t begin, size_t end, Node4* out);

/// q of every cell from theta; the increment is limited and cells far from rest forget instead (see the .cpp).
void update_multipliers(const KernelData& data, const float* theta, float* q, float scale_of_increment);

}  // namespace limberg::fem
