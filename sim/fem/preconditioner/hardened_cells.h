#pragma once
// Cells whose laws have come to resist far more than at rest, as the metric is to see them.
//
// The metric is the stiffness at rest (scalar_matrix.h). Fibres that are drawn out, tissue at its limit of stretch and
// muscle that pulls are ten to a thousand times as stiff, in whole regions and along some directions only, so that
// neither a short list of directions (stretched_cells.h) nor one scale for everything (metric_scale.h) holds what is
// lacking. So such cells enter the metric as stiff as they are: with
//
//   D_jl = the mean over i of dP_ij/dF_il  (material_points.h: scalar_stiffness_kPa), now and at rest,
//
// the part above zero of L = D - D_rest is added to the scalar matrix of the cell, sum_points V (grad N) L (grad N)^T.
// D is asked at the mean gradient of the points of one law: a look is to cost no more than a few iterations.
//
// The metric is given another model than the minimiser: the same nodes and cells, where those in question name stencils
// of their own. So all that is known of models (rows that a cut leaves alone, operators that are kept for an undo,
// hanging nodes) holds for these too. What a cell has goes over to those that a cut makes of it.
//
// Cells that are no boxes of a lattice (shaped_cells.h) are left as they are: their models have no multilevel cycle
// that could serve while a new factor is made.
#include <array>
#include <memory>
#include <vector>

#include "sim/fem/model/fem_model.h"
#include "sim/fem/solver/engine.h"

namespace limberg::fem {

class HardenedCells {
 public:
  /// Looks at all cells with material points at displacement u. True when what the metric should see is not what it is.
  bool follow(const FemModel& model, const NodeArray& u, const Engine& engine);
  /// To the next model, of so many cells; `cell_parent` as in ElasticSolver::set_model.
  void carry(const ParentList& cell_parent, size_t cells);
  /// The model as the metric sees it: itself when no cell has hardened. `of_itself`: the metric has a model of the
  /// same nodes, so parents are these themselves.
  std::shared_ptr<const FemModel> seen(const std::shared_ptr<const FemModel>& model, bool of_itself) const;
  bool empty() const { return hard_.empty(); }
  bool operator==(const HardenedCells&) const = default;

 private:
  struct Cell {
    int32_t cell = 0;
    std::array<float, 6> L{};  // kPa: xx, yy, zz, xy, xz, yz
    bool operator==(const Cell&) const = default;
  };
  std::vector<Cell> hard_;  // by cell
};

}  // namespace limberg::fem
