#pragma once
// The minimiser's metric: z = M^-1 r, the same scalar operator for x, y and z.
//
//   factor     a scalar matrix factored once (panels); immutable; rebuilt in the background after a cut
//   stale map  until the new factor is there, the old one is used through the nodes' ancestors: forces of copies are summed,
//              all copies take the ancestor's move, and Jacobi on the nodes around the cut lets copies part
//   springs    those that are not in the factor are added by the Woodbury identity: one solve each, once
//
// Every state is symmetric positive definite, so a step with a stale factor is only slower, never wrong.
// Sutures are folded into the next factor; hooks come and go and never are.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/fem/cholesky.h"
#include "sim/fem/scalar_matrix.h"
#include "sim/workers.h"

namespace limberg::fem {

class Preconditioner {
 public:
  explicit Preconditioner(Workers& workers);
  ~Preconditioner();

  /// `parent`: per node its index in the model before; empty for a first model.
  void set_model(std::shared_ptr<const FemModel> model);
  struct SpringEntry {
    SpringRow row;
    bool foldable = true;  // false for hooks
  };
  void set_springs(std::vector<SpringEntry> springs);

  /// Once per solver step, before apply. Takes a finished factor (after `adopt_after` steps it is waited for; as soon as
  /// it is there when `when_ready`), asks for a new one if the old is out of date.
  void begin_step(double mass_per_s2, int adopt_after, bool when_ready);
  void apply(const NodeArray& r, NodeArray& z);

  bool pending() const { return pending_ != nullptr; }
  bool stale() const;
  std::string describe() const;

 private:
  struct Pending;
  struct Column {
    SpringRow row;
    AlignedArray<float> y;  // M0^-1 w, per node
  };
  void submit(double mass_per_s2);
  void adopt();
  void map_factor();
  void apply_base(const NodeArray& r, NodeArray& z);
  void update_columns();

  Workers& workers_;
  std::shared_ptr<const FemModel> model_;
  std::vector<SpringEntry> springs_;

  std::shared_ptr<const ScalarFactor> factor_;
  std::vector<SpringRow> folded_;
  double factor_mass_ = 0;
  bool factor_is_current_ = false;
  std::vector<int32_t> ancestor_;  // current node -> node of the factor's model
  std::vector<int32_t> place_;     // current node -> elimination index, -1: none
  std::vector<float> jacobi_;      // empty, or per node
  NodeArray work_;

  std::vector<Column> columns_;
  std::vector<const float*> column_data_;
  NodeArray column_force_;
  std::vector<double> capacitance_;  // inverse of C^-1 + W^T M0^-1 W, row-major
  bool columns_dirty_ = true;

  std::unique_ptr<Pending> pending_;
};

}  // namespace limberg::fem
