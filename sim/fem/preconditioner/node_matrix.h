#pragma once
// The scalar stiffness of scalar_matrix.h row by row, in single precision, and how little of it a cut changes.
//
// Rows are nodes: of a model (those that are fixed, hanging or of no cell have an empty row), or of a coarser level.
// A row is a function of the cells around its node alone, summed in the order of the cells. So after a cut the rows
// whose cells are all the same are copied with new column numbers, and the result has the same bits as one made afresh.
#include <memory>
#include <span>
#include <vector>

#include "sim/fem/model/fem_model.h"
#include "sim/fem/preconditioner/scalar_matrix.h"

namespace limberg::fem {

/// Symmetric, both triangles; columns ascending in each row.
struct NodeMatrix {
  std::vector<int32_t> begin{0}, column;
  std::vector<float> value;
  int32_t rows() const { return int32_t(begin.size()) - 1; }
  bool operator==(const NodeMatrix&) const = default;
};

/// What happened to the nodes of a level from one version to the next.
struct NodeChange {
  std::vector<int32_t> parent;  // per node now: the node before that it comes from, or -1
  std::vector<int32_t> child;   // per node before: the one node that comes from it; -1: none, or several
  std::vector<uint8_t> dirty;   // per node now: its row is not the parent's row
};

/// Compares two versions of a model through FemModel::parent and `cell_parent` (per cell of `now`: its index in
/// `before`), or a model with itself under other springs. Rows are carried over as far as nodes and cells keep their
/// order. False: not at all.
bool compare_models(const FemModel& before, std::span<const SpringRow> springs_before, const FemModel& now,
                    std::span<const SpringRow> springs_now, const ParentList& cell_parent, NodeChange& change);

/// Sets all numbers outside a longest rising subsequence to -1 (-1 is no number).
void keep_rising(std::vector<int32_t>& a);

/// True when both have the same nodes, cells and constants, wherever they come from (FemModel::parent may differ).
bool same_model(const FemModel& a, const FemModel& b);

/// 1 for nodes that the minimiser moves: not fixed, not hanging, of some cell.
std::vector<uint8_t> free_nodes(const FemModel& model);

/// All rows; or, with a version before and what changed since, only the dirty ones.
NodeMatrix assemble_rows(const FemModel& model, std::span<const SpringRow> springs, double mass_per_s2,
                         std::span<const uint8_t> free);
NodeMatrix assemble_rows(const FemModel& model, std::span<const SpringRow> springs, double mass_per_s2,
                         std::span<const uint8_t> free, const NodeMatrix& before, const NodeChange& change);

/// Appends row `row` of `before` to `out`, its columns renamed.
void copy_row(const NodeMatrix& before, int32_t row, std::span<const int32_t> child, NodeMatrix& out);

/// The same matrix as lower columns in double for the direct
/// factor; each diagonal number d becomes d (1 + relative_shift).
ScalarMatrix lower_columns(const NodeMatrix& A, double relative_shift);

}  // namespace limberg::fem
