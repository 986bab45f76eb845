#pragma once
// The minimiser's metric: z = M^-1 r, the same scalar operator for x, y and z.
//
//   factor   up to `factor_up_to_nodes`: the scalar matrix of this
//            very model factored once (panels); made in the background
//   cycle    above, and for as long as the factor is not there: a
//            multilevel cycle (cycle.h), made at once for the model as it
//            is, from the cycle of the model before where there was one
//   springs  those that are not in the operator are added by the Woodbury identity: one application each, once
//
// Every state is symmetric positive definite and belongs to the topology that is shown; there is
// no stale operator. Sutures are folded into the next factor or cycle; hooks come and go and
// never are. The operators of the last few models are kept, so that an undo finds its own again.
//
// How the minimiser goes on depends on the factor's order, which comes from the factor before, and on which springs are
// folded in. past() says how the operators came to be, and take_up() makes them again, to the last bit.
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/fem/preconditioner/cholesky.h"
#include "sim/fem/preconditioner/scalar_matrix.h"
#include "sim/fem/solver/cycle.h"

namespace limberg::fem {

struct MetricPolicy {
  int32_t factor_up_to_nodes = 10000;  // 0: always the cycle
  const Kernels* kernels = nullptr;    // none: the default ones
};

struct MetricPast;  // the recipe of the operators in use, without these themselves: some numbers per node

class Preconditioner {
 public:
  explicit Preconditioner(Workers& workers, MetricPolicy policy = {});
  ~Preconditioner();

  /// FemModel::parent and `cell_parent` (per cell) name places in the
  /// model given last; without `cell_parent` the cycle is made afresh.
  void set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent);
  struct SpringEntry {
    SpringRow row;
    bool foldable = true;  // false for hooks
  };
  void set_springs(std::vector<SpringEntry> springs);

  /// Once per solver step, before apply. Takes a finished factor (after `adopt_after` steps it is waited for; as soon
  /// as it is there when `when_ready`; StepSettings::adopt_now), asks for a new one if the old is out of date, makes
  /// the cycle if one is needed.
  void begin_step(double mass_per_s2, int adopt_after, bool when_ready,
                  const std::function<bool(bool)>& adopt_now = {});
  /// The cycle that begin_step would make, made before: in between only time may pass.
  void make_ready(double mass_per_s2);
  void apply(const NodeArray& r, NodeArray& z);

  std::shared_ptr<const MetricPast> past() const;
  /// After set_model with the model that was there then, and set_springs. A factor that is not kept any more is made
  /// here and now.
  void take_up(const MetricPast& past);

  bool pending() const { return pending_ != nullptr; }
  bool on_cycle() const { return !factor_is_current_; }
  /// The cycle made last, if any, for reports and tests.
  std::shared_ptr<const ScalarCycle> cycle() const { return now_.cycle; }
  std::string describe() const;

 private:
  friend struct MetricPast;
  using NodeList = std::shared_ptr<const std::vector<int32_t>>;
  struct Recipe {  // all that a factor of a model depends on
    std::vector<SpringRow> folded;
    double mass_per_s2 = 0;
    NodeList order_from, ancestor;  // below
    size_t ordered_bytes = 0;
  };
  struct Pending;
  struct Operators {  // of one model
    std::shared_ptr<const FemModel> model;
    std::shared_ptr<const ScalarFactor> factor;
    std::shared_ptr<const Recipe> recipe;  // of the factor
    size_t ordered_bytes = 0;              // of the last factor in its line whose order was found afresh
    bool has_no_factor = false;            // it was tried
    std::shared_ptr<const ScalarCycle> cycle;
  };
  struct Column {
    SpringRow row;
    AlignedArray<float> y;  // M0^-1 w, per node
  };
  std::vector<SpringRow> foldable() const;
  bool springs_have_changed() const;
  std::span<const SpringRow> folded() const;
  void submit(std::shared_ptr<const Recipe> recipe);
  std::shared_ptr<const Recipe> next_recipe(double mass_per_s2) const;
  void adopt();
  void drop_pending();
  bool needs_cycle(double mass_per_s2) const;
  void make_cycle(double mass_per_s2);
  void use_factor();
  void operator_changed() { columns_.clear(), columns_dirty_ = true; }
  void apply_base(const NodeArray& r, NodeArray& z);
  void update_columns();

  Engine engine_;
  MetricPolicy policy_;
  std::vector<SpringEntry> springs_;
  Operators now_;
  std::deque<Operators> kept_;  // of other models, the latest first
  bool factor_is_current_ = false;
  std::vector<int32_t> place_;  // node -> elimination index of the current factor, -1: none
  NodeArray work_;
  ScalarCycle::Work cycle_work_;

  // What orders are inherited from: that of the last factor adopted, and the cycle of the model before.
  NodeList order_from_;
  size_t ordered_bytes_ = 0;
  NodeList ancestor_ = std::make_shared<std::vector<int32_t>>();  // current node -> node of that factor's model
  std::shared_ptr<const ScalarCycle> cycle_before_;
  ParentList cell_parent_;

  std::vector<Column> columns_;
  std::vector<const float*> column_data_;
  NodeArray column_force_;
  std::vector<double> capacitance_;  // inverse of C^-1 + W^T M0^-1 W, row-major
  bool columns_dirty_ = true;

  std::unique_ptr<Pending> pending_;
  std::vector<std::unique_ptr<Pending>> dropped_;  // still running, for a model that is gone
};

}  // namespace limberg::fem
