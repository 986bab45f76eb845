#pragma once
// What the kernel sources of one instruction set define between them (kernels.h says what each does).
#include "sim/fem/kernels/kernels.h"
#include "sim/fem/kernels/lanes.h"

namespace limberg::fem::LIMBERG_SET {

CellSums evaluate_tile(const CellView& data, const Tile& tile, const Node4* u, const float* q, Node4* slots,
                       float* theta, bool measure);
void sum_slots(const CellView& data, const Node4* slots, size_t begin, size_t end, Node4* out);
constexpr float slip_limit = 2.5f;    // layer_slide.h
constexpr float slide_least = 0.25f;  // layer_slide.h: squared area ratio from which downwards the energy is continued
/// Cells [first, last) of a tile, all of one stencil; `local`, `out`: the tile's nodes.
void cells_wide(const CellView& data, int first, int last, const v4* local, v4* out, const float* q, float* theta,
                bool measure, CellSums& sums);
/// What the cells of a block add: forces per lane and corner, and energies (without their scale).
struct LaneForces {
  alignas(64) v4 force[16][8];
  float work[16], bulk[16], pre[16], layers[16];
};
void cells_apart(const CellView& data, int first_cell, const LaneBlock& block, const v4* local, const float* q,
                 float* theta, bool measure, LaneForces& out);
/// Cells of one stencil in a row from which a cell to a lane pays, even if some lanes idle (measured).
constexpr int least_wide = part_lanes == 16 ? 6 : part_lanes == 8 ? 4 : 3;
void update_multipliers(const CellView& data, const float* theta, float* q, float scale_of_increment, size_t first,
                        size_t last);

void viscous_cells(const ViscousView& data, const Node4* u, size_t first, size_t last, CellSums* sums, float* force);

void dot(const Node4* a, const Node4* b, size_t nodes, size_t first, size_t last, double* sums);
void add_scaled(Node4* y, float s, const Node4* x, size_t nodes, size_t first, size_t last);
void add_scaled_dot(Node4* y, float s, const Node4* x, const Node4* z, size_t nodes, size_t first, size_t last,
                    double* sums);
void combine(Node4* out, const Node4* a, float s, const Node4* b, size_t nodes, size_t first, size_t last);
void subtract(Node4* out, const Node4* a, const Node4* b, size_t nodes, size_t first, size_t last);
void subtract_outer(Node4* y, const float* const* columns, const Node4* s, int count, size_t nodes, size_t first,
                    size_t last);
void max_square(const Node4* a, size_t nodes, size_t first, size_t last, double* sums);
bool all_finite(const Node4* a, size_t nodes, size_t first, size_t last);

void panels_forward(const PanelView& f, size_t first, size_t last, Node4* y, Node4* log, const PanelScratch& s);
void panels_backward(const PanelView& f, size_t first, size_t last, Node4* y, const PanelScratch& s);

void multiply_transposed(const double* A, size_t leading, int rows, int count, int depth, double* C, size_t ldc);
bool factor_panel(double* L, size_t leading, int rows, int count);

void scale_nodes(const float* scale, const Node4* r, Node4* x, size_t first, size_t last);
void residual(const GroupView& A, const Node4* r, const Node4* x, Node4* t, size_t first, size_t last);
void relax(const GroupView& A, const float* scale, const Node4* r, const Node4* x, Node4* z, size_t first, size_t last);
void weigh(const int32_t* begin, const int32_t* column, const float* weight, const Node4* in, Node4* out, size_t first,
           size_t last);
void weigh_add(const int32_t* begin, const int32_t* column, const float* weight, const Node4* in, Node4* out,
               size_t first, size_t last);

extern const Kernels kernels;

}  // namespace limberg::fem::LIMBERG_SET
