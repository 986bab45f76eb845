#pragma once
// Sums forces of some cells into nodes: each node adds its own, in cell order, so any number of workers gives the same bits.
#include <array>
#include <vector>

#include "sim/fem/simd.h"
#include "sim/geometry/vec.h"
#include "sim/workers.h"

namespace limberg::fem {

using CellForce = Eigen::Matrix<float, 4, 8>;  // per corner: x, y, z and the norm

class CellScatter {
 public:
  CellScatter() = default;
  /// Nodes of every cell, corner order of fem_model.h; node_count of the model.
  CellScatter(const std::vector<std::array<int32_t, 8>>& cells, size_t node_count);
  /// g += the cells' forces; `measure`: the norms to w.
  void add(const std::vector<CellForce>& force, NodeArray& g, bool measure, Workers& workers) const;

 private:
  std::vector<int32_t> nodes_, begin_, list_;  // nodes with cells; per node its 8 * cell + corner, ascending
};

}  // namespace limberg::fem
