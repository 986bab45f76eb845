#pragma once
// The loops that take the time, as a table of functions: one table per instruction set, made from the same sources.
//
//   plain    whatever the compiler's baseline is (SSE2 on x86-64)
//   avx2     AVX2 and FMA
//   avx512   AVX-512 F, VL, BW, DQ
//
// All tables give the same bits (tests): every sum has one order, which no register's width changes, and a product and
// a sum are two roundings (not every machine can fuse them). Everything goes through pointers to plain data: kernels
// share no function with the rest of the program (lanes.h). All arrays of nodes begin on 64 bytes and may be read and
// written up to the next 64 (AlignedArray).
#include "sim/base/node4.h"

namespace limberg::fem {

/// One stencil as the kernel wants it (element_system.h has the formulas).
struct alignas(64) KernelStencil {
  float K[64];       // column b at K[8 b ...]
  float f0[32];      // 8 nodes of 4
  float volume = 0;  // mm^3
  float p0 = 0;      // kPa
  float ke = 0;      // kPa, effective bulk stiffness
  float r = 0;       // lambda / (lambda + k); 0: no multiplier
  // Sample gradients off the centre: per axis, of the four cell edges along it, in corner order (1 / mm).
  float bx[4], by[4], bz[4];
  bool centred = true;
  float inv4h[3] = {0, 0, 0};  // 1 / (4 edge), of the cells of its level
  // slide not 0: layers share it (layer_slide.h). Then it is
  // centred, and bx, by, bz belong to the layers' sample point.
  // Axes along the layers and their normal: four numbers each.
  float slide = 0, rest = 0, rest_lambda = 0;
  float along[4] = {1, 0, 0, 0}, across[4] = {0, 1, 0, 0}, normal[4] = {0, 0, 1, 0};
};

struct KernelCell {
  uint16_t node[8];  // in the tile's local list
  int32_t stencil = 0;
  float scale = 0;
};

/// Cells that each have a stencil of their own, a cell to a lane: row i of a number lies at 16 i.
struct alignas(64) LaneBlock {
  enum Kind : uint8_t { centred, off_centre, layers, none };  // what they have in common; none: not in a block
  float K[64 * 16], f0[32 * 16], volume[16], p0[16], ke[16], bx[4 * 16], by[4 * 16], bz[4 * 16], inv4h[3 * 16];
  float slide[16], rest[16], rest_lambda[16], along[3 * 16], across[3 * 16], normal[3 * 16];  // of `layers` only
  int32_t cell[16];  // from the tile's first on, ascending; what fills up repeats the last
  int32_t count = 0;
  Kind kind = none;
};
/// Those of a tile, in the order in which their first cells come.
struct TileLanes {
  const LaneBlock* block = nullptr;
  const LaneBlock::Kind* kind = nullptr;  // per cell of the tile
};

struct Tile {
  int32_t first_cell = 0, last_cell = 0;
  int32_t first_slot = 0, last_slot = 0;
  TileLanes lanes = {};  // no block: none
};
inline constexpr int max_tile_nodes = 8192;

struct CellSums {
  double energy = 0;     // uJ, relative to the undeformed state
  double magnitude = 0;  // sum of |terms|: its rounding unit is the noise of `energy`
};

/// Cells in tile order, and which slots of the tiles a node's force is summed from.
struct CellView {
  const KernelStencil* stencils;
  const KernelCell* cells;
  const int32_t* slot_node;
  const int32_t *node_slots_begin, *node_slots;  // per node: its slots in ascending order
};

/// Relaxing points of a stencil, four by four; what fills up has no volume (viscous_points.h has the formulas).
struct alignas(64) ViscousGroup {
  double B[24][4];   // grad N: 3 a + j
  double volume[4];  // mm^3
};
struct ViscousCell {
  int32_t node[8];
  int32_t group = 0, groups = 0;
  int32_t held = 0;  // first of its groups in `held`
  float scale = 0;
};
struct ViscousView {
  const ViscousGroup* groups;
  const ViscousCell* cells;
  const float* held;  // per cell's group 7 x 4: the six numbers of M (G mu I + B) M^T (diagonal, 01, 12, 20), and G s
};

/// Supernodes of a factor (panel_factor.h).
struct Panel {
  int32_t first = 0, columns = 0, rows = 0;  // rows: all, the diagonal block's included
  int32_t inside = 0;                        // of these, those that its subtree may write (below); others go to the log
  int32_t rows_begin = 0;                    // of the off-diagonal rows
  size_t values = 0;
};
struct PanelView {
  const Panel* panels;
  const int32_t* rows;
  const float* values;
};
/// Blocks of a factor in the making have columns of a multiple of so many rows, zero or nobody's below the last.
inline constexpr int leading_step = 16;

/// What one thread needs of its own: nodes for the most columns; for the rows, in blocks of 16.
struct PanelScratch {
  Node4 *columns, *rows;
  float* x;  // 48 per block of 16 rows
};

/// A sparse matrix by diagonals of four rows (row_groups.h).
struct GroupView {
  const int32_t *begin, *base;
  const float* number;
};

struct Kernels {
  const char* name;

  // Cells. `measure`: w of a slot is the sum of the norms of the cell forces there.
  CellSums (*evaluate_tile)(const CellView&, const Tile&, const Node4* u, const float* q, Node4* slots, float* theta,
                            bool measure);
  void (*sum_slots)(const CellView&, const Node4* slots, size_t first, size_t last, Node4* out);
  /// q of cells [first, last) from theta; the increment is limited and cells far from rest forget instead (cells.cpp).
  void (*update_multipliers)(const CellView&, const float* theta, float* q, float scale_of_increment, size_t first,
                             size_t last);

  /// Relaxing neo-Hookean points of cells [first, last): energies
  /// to sums, forces (per corner x, y, z and the norm) to `force`.
  void (*viscous_cells)(const ViscousView&, const Node4* u, size_t first, size_t last, CellSums* sums, float* force);

  // Vectors of nodes: blocks [first, last) of 32 x 4 nodes, the last one of them ending at `nodes`. Sums run in float
  // over a block; every block's goes to sums[block] in double.
  void (*dot)(const Node4* a, const Node4* b, size_t nodes, size_t first, size_t last, double* sums);
  void (*add_scaled)(Node4* y, float s, const Node4* x, size_t nodes, size_t first, size_t last);  // y += s x
  void (*add_scaled_dot)(Node4* y, float s, const Node4* x, const Node4* z, size_t nodes, size_t first, size_t last,
                         double* sums);
  void (*combine)(Node4* out, const Node4* a, float s, const Node4* b, size_t nodes, size_t first,
                  size_t last);  // a + s b
  void (*subtract)(Node4* out, const Node4* a, const Node4* b, size_t nodes, size_t first, size_t last);
  /// y -= sum_j column_j s_j: columns of `count` scalar fields (each one float per node), s_j one Node4 each.
  void (*subtract_outer)(Node4* y, const float* const* columns, const Node4* s, int count, size_t nodes, size_t first,
                         size_t last);
  /// sums[block] = largest squared norm of a node; not a number if any entry is.
  void (*max_square)(const Node4* a, size_t nodes, size_t first, size_t last, double* sums);
  bool (*all_finite)(const Node4* a, size_t nodes, size_t first, size_t last);

  // Panels [first, last), forward (adds of rows that are not inside go to `log`, one after the other) and backward.
  void (*panels_forward)(const PanelView&, size_t first, size_t last, Node4* y, Node4* log, const PanelScratch&);
  void (*panels_backward)(const PanelView&, size_t first, size_t last, Node4* y, const PanelScratch&);

  // Dense blocks in double, column-major, `leading` numbers from one column to the next (preconditioner/supernodal.h).
  /// The part on and below the diagonal of C = A B^T, A of `rows` x `depth`, B its first `count` rows. C, and what is
  /// read of A, reach up to the next leading_step rows.
  void (*multiply_transposed)(const double* A, size_t leading, int rows, int count, int depth, double* C, size_t ldc);
  /// Cholesky of the first `count` rows of L, and the rows below solved with it; L begins on a multiple of leading_step
  /// and what is above its diagonal is overwritten. False: not positive definite.
  bool (*factor_panel)(double* L, size_t leading, int rows, int count);

  // Groups [first, last) of four rows; `scale` is one number per node.
  void (*scale_nodes)(const float* scale, const Node4* r, Node4* x, size_t first, size_t last);  // x = scale r
  void (*residual)(const GroupView&, const Node4* r, const Node4* x, Node4* t, size_t first,
                   size_t last);  // t = r - A x
  void (*relax)(const GroupView&, const float* scale, const Node4* r, const Node4* x, Node4* z, size_t first,
                size_t last);  // z = x + scale (r - A x)

  // Rows [first, last) of weights (coarsening.h) times nodes: out = W in, out += W in.
  void (*weigh)(const int32_t* begin, const int32_t* column, const float* weight, const Node4* in, Node4* out,
                size_t first, size_t last);
  void (*weigh_add)(const int32_t* begin, const int32_t* column, const float* weight, const Node4* in, Node4* out,
                    size_t first, size_t last);
};

}  // namespace limberg::fem
