#pragma once
// The multilevel metric: z = M^-1 r for the scalar stiffness A by one symmetric V-cycle.
//
//   x = S r;  x += P M_c^-1 P^T (r - A x);  z = x + S (r - A x)
//
//   S    diagonal, relaxation / sum_j |A_ij|. By Gershgorin S A has
//        no eigenvalue above `relaxation` < 2, whatever was cut
//   P    coarsening.h; the coarse matrix is P^T A P (galerkin.h), so nothing depends on where A came from
//   M_c  the same cycle one level coarser, or the exact factor of the coarsest matrix
//
// M^-1 = 2 S - S A S + (I - S A) P M_c^-1 P^T (I - A S) is symmetric positive definite
// because 2 S - S A S is. It takes as many steps as the exact factor and is made in a
// fraction of its time. After a cut most rows are copied (node_matrix.h, galerkin.h). The
// coarsest matrix is eliminated in an order that depends on places alone (dissection_order),
// copies beside their originals, so it costs next to nothing and does not age.
//
// Immutable once made. Every loop runs over ranges that share nothing, so
// threads can take parts of it; small levels stay on the calling thread.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/fem/model/row_groups.h"
#include "sim/fem/preconditioner/cholesky.h"
#include "sim/fem/preconditioner/galerkin.h"

namespace limberg::fem {

class ScalarCycle {
 public:
  /// What apply writes on the way; any cycle may use any.
  struct Work {
    struct Level {
      PaddedNodes x;
      NodeArray t, r, z;  // residual; right-hand side and answer of this level (not of the finest)
    };
    std::vector<Level> level;
    NodeArray bottom;
  };
  /// How much was made again: of the rows of the finest and of the next matrix.
  struct Made {
    int32_t rows = 0, of_rows = 0, coarse_rows = 0, of_coarse_rows = 0;
  };

  /// `mass_per_s2` as in assemble_scalar.
  static std::shared_ptr<const ScalarCycle> build(std::shared_ptr<const FemModel> model, std::vector<SpringRow> springs,
                                                  double mass_per_s2);
  /// From a cycle of the model before; `cell_parent` per cell, FemModel::parent per node. Same bits as a build on the
  /// same blocks; whatever does not fit together is made afresh.
  static std::shared_ptr<const ScalarCycle> rebuild(const ScalarCycle& before, std::shared_ptr<const FemModel> model,
                                                    const ParentList& cell_parent, std::vector<SpringRow> springs,
                                                    double mass_per_s2);

  /// r and z: one entry per node of the model; where nothing is free r must be and z will be zero.
  void apply(const NodeArray& r, NodeArray& z, Work& work, const Engine& engine) const;

  const FemModel& model() const { return *model_; }
  std::span<const SpringRow> springs() const { return springs_; }
  double mass_per_s2() const { return mass_per_s2_; }
  const Made& made() const { return made_; }
  int levels() const { return int(level_.size()) + 1; }
  size_t bytes() const;
  /// True when all matrices and weights have the same bits.
  bool same_matrices(const ScalarCycle& o) const;
  std::string describe() const;

 private:
  struct Level {
    NodeMatrix A;
    RowGroups groups;
    AlignedArray<float> scale;
    Coarsening coarse;
  };
  void make(const ScalarCycle* before, const ParentList& cell_parent);
  void factorize_bottom(std::span<const std::array<int32_t, 3>> at);
  void descend(size_t level, const Node4* r, Node4* z, Work& work, const Engine& engine) const;

  std::shared_ptr<const FemModel> model_;
  std::vector<SpringRow> springs_;
  double mass_per_s2_ = 0;
  Vec3 zero_mm_ = Vec3::Zero();
  std::vector<Level> level_;  // the finest first
  NodeMatrix bottom_;
  ScalarFactor factor_;
  Made made_;
};

}  // namespace limberg::fem
