#pragma once
// The material of a FemModel as the minimiser sees it: energy and gradient at a displacement, and the multipliers.
#include <memory>

#include "sim/fem/element_kernel.h"
#include "sim/fem/fem_model.h"
#include "sim/workers.h"

namespace limberg::fem {

/// Effective volumetric stiffness ke in kPa of a stencil, as it enters gradient and preconditioner.
double effective_bulk_kPa(const Stencil& s, bool augmented);

class ElementSystem {
 public:
  explicit ElementSystem(std::shared_ptr<const FemModel> model, bool augmented = true);

  /// Energy; g = dE/du of the cells at every node, fixed ones included. `measure`: w of a node = sum of the norms of the
  /// cell forces that meet there (otherwise 0). Same bits for any number of workers.
  CellSums evaluate(const NodeArray& u, NodeArray& g, bool measure, Workers& workers);
  /// One multiplier update from the theta of the last evaluate. Returns false if no cell has a multiplier.
  bool update_multipliers(double scale_of_increment = 1);

  /// theta = J - 1 of the last evaluate, and q, both in the model's cell order.
  float theta(size_t cell) const { return theta_[size_t(slot_of_cell_[cell])]; }
  float q(size_t cell) const { return q_[size_t(slot_of_cell_[cell])]; }
  void set_q(size_t cell, float v) { q_[size_t(slot_of_cell_[cell])] = v; }
  size_t cells() const { return slot_of_cell_.size(); }
  /// What turns the augmented energy of the last evaluate into the plain one: sum V (lambda/2 theta^2 - ke/2 (theta+q)^2).
  double energy_to_primal() const;
  float min_theta() const;
  int inverted() const;  // cells with J <= 0 at the last evaluate
  bool has_multipliers() const { return has_multipliers_; }
  const KernelData& kernel() const { return data_; }

 private:
  KernelData data_;
  std::vector<int32_t> slot_of_cell_;  // position in tile order of a model cell
  AlignedArray<float> theta_, q_;
  NodeArray slots_;
  std::vector<CellSums> tile_sums_;
  bool has_multipliers_ = false;
};

}  // namespace limberg::fem
