#pragma once
// The scalar stiffness whose factor preconditions the minimiser: one number per pair of nodes, the same for x, y and z.
//
//   A_ij = sum_cells scale * ( K_ab + ke V B_a . B_b )  +  sum_springs k w_i w_j  +  mass terms on the diagonal
//
// over the free nodes: those that are not held whole. Where nodes slide, component_metric.h gives each component a
// model in which none does. K is the exact Hessian of the quadratic part of the energy; the second term stands for the
// volumetric part (ke is small thanks to the multipliers). Always symmetric positive definite.
//
// Hanging nodes are no rows: what is assembled is P^T A P (fem_model.h), cell by
// cell: a cell with hanging corners enters as the matrix of the unknowns that
// move it. The same for springs, whose weights go to the masters, and for masses.
#include <memory>
#include <span>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

/// A spring as the preconditioner sees it: k and a weight per free node, the same for x, y and z.
struct SpringRow {
  int32_t id = 0;
  double k_mN_per_mm = 0;
  std::vector<int32_t> node;  // nodes of the model, each once; fixed ones left out, masters for hanging ones
  std::vector<double> w;
  Vec3 rest_a_mm = Vec3::Zero(), rest_b_mm = Vec3::Zero();  // where it is attached at rest: its identity over cuts
};
SpringRow spring_row(const FemModel& model, const Spring& spring);
bool same_spring(const SpringRow& a, const SpringRow& b);

/// A piece that nothing holds would make the matrix singular: each diagonal number grows by this part of itself, far
/// less than the smallest stiffness of a piece that is held.
inline constexpr double floating_shift = 1e-5;

/// K + ke V B B^T of a full cell, and what its material points add.
Mat8 scalar_cell_matrix(const FemModel& model, const Stencil& s, bool augmented);

/// Lower triangle by columns, rows ascending, diagonal first.
struct ScalarMatrix {
  std::vector<int32_t> node_of_row;  // free nodes, ascending
  std::vector<int32_t> row_of_node;  // -1: fixed, hanging, or of no cell
  std::vector<int32_t> begin, row;
  std::vector<double> value;
  int32_t n() const { return int32_t(node_of_row.size()); }
};

/// `mass_per_s2`: added to the diagonal times the node's mass
/// (1/dt^2 + damping/dt of a dynamic step; 0 = quasi-static).
ScalarMatrix assemble_scalar(const FemModel& model, std::span<const SpringRow> springs, double mass_per_s2,
                             bool augmented = true);

/// Elimination order of `now` from that of an older model: a node takes its
/// ancestor's place, copies side by side. `order_before[k]` = old node eliminated
/// k-th; `ancestor` = old node of each node now. Returns rows of `now` in order.
std::vector<int32_t> inherited_order(const ScalarMatrix& now, std::span<const int32_t> order_before,
                                     std::span<const int32_t> ancestor);

}  // namespace limberg::fem
