#pragma once
// Sums forces of some cells into nodes: each node adds its own,
// in cell order, so any number of workers gives the same bits.
#include <array>
#include <vector>

#include "sim/base/simd.h"
#include "sim/base/workers.h"
#include "sim/fem/kernels/kernels.h"
#include "sim/geometry/vec.h"

namespace limberg::fem {

using CellForce = Eigen::Matrix<float, 4, 8>;  // per corner: x, y, z and the norm

/// A cell's share of its nodes' forces: `f` (one row per corner) times the cell's scale.
inline CellForce cell_force(const Eigen::Matrix<double, 8, 3>& f, double scale) {
  CellForce out;
  for (int a = 0; a < 8; ++a) {
    const Vec3 v = scale * f.row(a).transpose();
    out.col(a) << v.cast<float>(), float(v.norm());
  }
  return out;
}

/// In cell order.
inline CellSums total(const std::vector<CellSums>& sums) {
  CellSums all;
  for (const CellSums& s : sums) all.energy += s.energy, all.magnitude += s.magnitude;
  return all;
}

class CellScatter {
 public:
  CellScatter() = default;
  /// Nodes of every cell, corner order of fem_model.h; node_count of the model.
  /// `corners`: how many of a cell's are used, the first ones; empty: all eight.
  CellScatter(const std::vector<std::array<int32_t, 8>>& cells, size_t node_count,
              const std::vector<uint8_t>& corners = {});
  /// g += the cells' forces; `measure`: the norms to w.
  void add(const std::vector<CellForce>& force, NodeArray& g, bool measure, Workers& workers) const;

 private:
  std::vector<int32_t> nodes_, begin_, list_;  // nodes with cells; per node its 8 * cell + corner, ascending
};

}  // namespace limberg::fem
