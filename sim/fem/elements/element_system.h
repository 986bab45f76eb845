#pragma once
// The material of a FemModel as the minimiser sees it: energy and gradient at a displacement, and the multipliers.
//
// Works on displacements u = x - X, so that a flat, unloaded state is exactly zero and single precision
// keeps its digits: with K the stencil, B_a = grad N_a at its sample point, G = sum u_a B_a^T, F = I + G,
//
//   f_a = scale * ( sum_b K_ab u_b + f0_a + V ( (p - p0)(cof F - I) + p I ) B_a ),   f0_a = (K X)_a - p0 V B_a
//   p   = ke (theta + q),  theta = J - 1
//
// (and what a cell that layers share adds, layer_slide.h).
// Augmented Lagrangian with the pressure eliminated per cell: q is the stored multiplier over the penalty k = 3 mu
// (6 mu where layers share the cell),
// ke = lambda k / (lambda + k). At the fixed point of update_multipliers p = lambda theta,
// so the answer is that of the plain energy; the minimiser only ever meets the stiffness
// ke. Cells with lambda below `primal_below` mu (nu < 0.4) keep q = 0 and ke = lambda.
//
// A penalty carries only so much. The Hessian of the augmented energy holds p d2J, which has both signs, and nothing
// but the material and ke cof F cof F^T to outweigh it: where p is several times k, the minimum sought is none of the
// augmented energy, and no order of updates finds it (Bertsekas, Constrained Optimization and Lagrange Multiplier
// Methods, 2.2: the penalty must exceed a bound). overloaded() says so, and plain() takes lambda itself instead.
//
// Cells are kept in tiles of the lattice. A tile gathers its nodes into a small local
// array, works there, and leaves its forces in slots of its own; slots are summed per
// node in tile order. So the result has the same bits for any number of workers.
#include <memory>
#include <span>
#include <vector>

#include "sim/fem/elements/effective_bulk.h"
#include "sim/fem/elements/lane_blocks.h"
#include "sim/fem/model/fem_model.h"
#include "sim/fem/model/tiles.h"
#include "sim/fem/solver/engine.h"

namespace limberg::fem {

/// Whether two models have one list of stencils and laws in common, not only equal ones.
bool same_stencils(const FemModel& a, const FemModel& b);

/// F = I + sum u_a B_a^T of a cell, in double.
inline Mat3 gradient_at(const Eigen::Matrix<double, 8, 3>& B, const HexCell& c, const NodeArray& u) {
  Mat3 F = Mat3::Identity();
  for (int a = 0; a < 8; ++a) {
    const Node4& v = u[size_t(c.node[size_t(a)])];
    F += Vec3(double(v.x), double(v.y), double(v.z)) * B.row(a);
  }
  return F;
}

/// Everything the kernels read of the cells.
struct KernelData {
  std::shared_ptr<const AlignedArray<KernelStencil>> stencils;
  AlignedArray<KernelCell> cells;  // in tile order
  std::vector<Tile> tiles;
  std::vector<std::shared_ptr<const LaneBlocks>> lanes;  // of the tiles; null: every cell shares its stencil
  std::vector<int32_t> slot_node;
  std::vector<int32_t> node_slots_begin, node_slots;  // per node: its slots in ascending order
  CellView view() const {
    return {stencils->data(), cells.data(), slot_node.data(), node_slots_begin.data(), node_slots.data()};
  }
};

class ElementSystem {
 public:
  /// `before`, `system_before`: the last model and its system,
  /// of which stencils and tiles that both have are taken over.
  explicit ElementSystem(std::shared_ptr<const FemModel> model, bool augmented = true, const FemModel* before = nullptr,
                         const ElementSystem* system_before = nullptr);

  /// Energy; g = dE/du of the cells at every node, fixed ones included. `measure`: w of a node = sum of the norms of
  /// the cell forces that meet there (otherwise 0). Same bits for any number of workers.
  CellSums evaluate(const NodeArray& u, NodeArray& g, bool measure, const Engine& engine);
  /// From now on sum K_ab/2 u_a . u_b in place of the energy: linear in what it asks for, convex, least at rest. It
  /// knows no rotation and no volume, but leads out of any tangle (LbfgsSolver).
  void shape_only(bool on);
  /// From now on lambda in place of ke, and no multipliers. Off again: they are those of p = lambda theta at the last
  /// evaluate, so that energy_to_primal, gradient and what is saved agree with the energy that was minimised.
  void plain(bool on);
  /// Whether one cell in 64, or more, has a multiplier beyond twice the penalty: |q| > 2, p about 2 k. (The shipped
  /// rhomboid and Z-plasty have up to 1.3, in three cells, 2026-11-25.)
  bool overloaded() const;
  /// One multiplier update from the theta of the last evaluate. Returns false if no cell has a multiplier.
  bool update_multipliers(const Engine& engine, double scale_of_increment = 1);
  /// The multipliers as they were if theta stayed as the last evaluate found it: p = lambda theta. `before` gets those
  /// that were there, for swap_multipliers; the cells of `but` keep theirs. False, and nothing done, if none has one.
  bool settle_multipliers(AlignedArray<float>& before, std::span<const int32_t> but = {});
  void swap_multipliers(AlignedArray<float>& q) { q_.swap(q); }

  /// theta = J - 1 of the last evaluate, and q, both in the model's cell order.
  float theta(size_t cell) const { return theta_[size_t(slot_of_cell_[cell])]; }
  float q(size_t cell) const { return q_[size_t(slot_of_cell_[cell])]; }
  void set_q(size_t cell, float v) { q_[size_t(slot_of_cell_[cell])] = v; }
  size_t cells() const { return slot_of_cell_.size(); }
  /// What turns the augmented energy of the last evaluate into
  /// the plain one: sum V (lambda/2 theta^2 - ke/2 (theta+q)^2).
  double energy_to_primal() const;
  float min_theta() const;
  int inverted() const;  // cells with J <= 0 at the last evaluate
  bool has_multipliers() const { return has_multipliers_; }
  const KernelData& kernel() const { return data_; }

 private:
  /// `earlier`: a system whose cells the model begins with; `changed`, per cell of it: 1 when it is not what it was.
  /// Returns, per tile, that of the earlier system which it begins with; -1: none.
  std::vector<int32_t> lay_tiles(const FemModel& model, const ElementSystem* earlier, std::span<const uint8_t> changed);
  /// Blocks of tiles that are those of before are shared with it.
  void lay_lanes(const ElementSystem* earlier, std::span<const int32_t> tile_before, int32_t same_up_to);

  KernelData data_;
  TileOrder order_;
  AlignedArray<KernelStencil> shape_stencils_, plain_stencils_;  // made when first asked for
  bool shape_only_ = false, plain_ = false;
  std::vector<int32_t> slot_of_cell_;  // position in tile order of a model cell
  AlignedArray<float> theta_, q_;
  NodeArray slots_;
  std::vector<CellSums> tile_sums_;
  bool has_multipliers_ = false;
};

}  // namespace limberg::fem
