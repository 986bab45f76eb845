#pragma once
// The elasticity solver: how the parts of this folder work together in one step.
//
//   u     displacement of all nodes, float, 16 bytes each; held components
//         keep theirs (zero, or what set_displacement gave), and g is zero there
//   E(u)  cells (ElementSystem) + springs (SpringForces) + contacts
//         (ContactForces) + weight and loads (DeadLoads) + in a dynamic step the incremental potential
//         sum_i a_i/2 |u_i - t_i|^2,  a = m (1/h^2 + c/h),  t = ((U + h V)/h^2 + c U/h) / (1/h^2 + c/h)
//         backward Euler: h = dt, U = u0, V = v0.  BDF2: h = 2/3 dt, U = (4 u0 - u_before)/3, V = (4 v0 - v_before)/3.
//         In both the new velocity is (u - U)/h. (BDF2: Hairer &
//         Wanner, Solving Ordinary Differential Equations II, V.1.)
//   d     = -H g, H: L-BFGS over a scalar matrix, factored or by a multilevel cycle
//         (Preconditioner; ComponentMetric where nodes are held along some axes);
//         Armijo line search; when the change of energy is below the noise of single precision,
//         the slope decides instead (Hager & Zhang 2005, "approximate Wolfe")
//         where cells are drawn out many times H gets what it lacks there (stretched_cells.h), where laws have
//         hardened as well (hardened_cells.h)
//   P     hanging nodes, if any, follow their masters: u is spread to them
//         after every move, evaluate() hands their forces on, so g is zero
//         there and they take no part in any product (hanging_nodes.h)
//         when every step is cut, H's metric is scaled (metric_scale.h)
//   q     multipliers, updated after every third accepted iterate (ElementSystem::update_multipliers); none, and lambda
//         itself, while they would be several times the penalty (ElementSystem::plain)
//
// A tangle that the energy does not lead out of (many cells inverted and no balance in sight for forty iterations:
// layers of very different stiffness thrown together) is undone in two stages. First the energy is replaced by its
// quadratic part about the rest shape, which is convex and, under whatever springs there are, leaves no cell folded
// by another. Then the whole energy takes over from there. Only in quasi-static steps, only where something holds
// every piece (the quadratic part would turn a free one back as it was), and not with laws beside the quadratic part.
//
// The history outlives the step: moving a target or updating q only shifts the
// gradient, so old pairs stay true as long as no pair is taken across such a shift.
// A new model or another set of springs clears it. Other contacts do not: the metric
// knows nothing of them, the pairs learn them, and a pair that is out of date still
// makes a positive definite operator. A stitch that is drawn clears it: its pull is
// 10 N where 1 mN is out of balance, the metric knows its direction exactly, and the
// little that pairs from contacts that come and go say of it throws the tissue about
// by centimetres (shipped Z-plasty, 2026-11-22: first directions of up to 82 m, and
// 1263 checks of what touches what where there are 838 now).
#include <memory>
#include <vector>

#include "sim/fem/elements/element_system.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/elements/viscous_points.h"
#include "sim/fem/forces/contact_forces.h"
#include "sim/fem/forces/dead_loads.h"
#include "sim/fem/forces/spring_forces.h"
#include "sim/fem/preconditioner/component_metric.h"
#include "sim/fem/preconditioner/hardened_cells.h"
#include "sim/fem/preconditioner/stretched_cells.h"
#include "sim/fem/solver/distance_estimate.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/fem/solver/lbfgs.h"
#include "sim/fem/solver/loose_pieces.h"
#include "sim/fem/solver/metric_scale.h"
#include "sim/fem/solver/stall_watch.h"

namespace limberg::fem {

/// What scenes never change: benches ask what each of them is worth.
struct MinimiserPolicy {
  int pairs = 0;  // of the history; 0: as suits the size
  // false: no distance_mm, and the residual against the forces of
  // the step's beginning. Saves an evaluation and a direction.
  bool estimate_error = true;
};

class LbfgsSolver final : public ElasticSolver {
 public:
  explicit LbfgsSolver(Workers& workers, bool augmented = true, MetricPolicy policy = {}, MinimiserPolicy own = {})
      : engine_(workers, policy.kernels ? *policy.kernels : default_kernels()),
        augmented_(augmented),
        own_(own),
        metric_(workers, policy) {}

  void set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent) override;
  void set_springs(std::span<const Spring> springs) override;
  void set_contacts(std::span<const Contact> contacts) override;
  void set_gravity(const Vec3& m_s2) override;
  Vec3 gravity_m_s2() const override { return gravity_m_s2_; }
  void set_loads(std::span<const DeadLoad> loads) override;
  std::span<const DeadLoad> loads() const override { return load_list_; }
  StepReport step(const StepSettings& settings) override;
  void make_ready(const StepSettings& settings) override;

  std::span<const Vec3f> displacement_mm() const override { return shown_; }
  void set_displacement_mm(std::span<const Vec3f> u) override;
  SolverState save() const override;
  void restore(const SolverState& state) override;
  std::shared_ptr<const SolverPath> path() const override;
  void take_up(const SolverPath& path) override;
  std::span<const float> memory() const override { return viscous_.memory(); }
  Vec3 spring_force_mN(int32_t id) const override;
  double contact_force_mN(size_t i) const override;
  Vec3 contact_friction_mN(size_t i) const override;
  size_t contacts() const override { return contacts_.size(); }
  std::vector<SupportForce> support_forces_mN() const override;
  Vec3 load_force_mN() const override { return loads_.sum_mN(); }
  void cell_J(std::vector<float>& J) const override;
  Mat3 cell_F(int32_t cell) const override;
  std::string describe() const override;
  const FemModel& model() const override { return *model_; }
  const Preconditioner& metric() const { return metric_.first(); }
  /// The largest move that the metric alone answers such forces with: what they would do, to first order. Held
  /// components take none. Only after a step.
  double first_move_mm(std::span<const SupportForce> forces_mN);
  /// The largest move of the nodes marked with 1 in the direction that was found last: at a step's end, where the next
  /// iteration would go (StepReport::distance_mm).
  double next_move_mm(std::span<const uint8_t> marked) const;

 private:
  struct Value {
    double energy = 0;
    double noise = 0;
    bool finite() const;
  };
  void forget();  // the iterations so far
  /// For the rest of the step the plain energy, or the augmented one. Where that is another than before the pairs go.
  void take_plain_energy(bool plain, Value& value);
  /// Whether the forces at u_ are what the displacements' last bits make of them: |g| is at most the change
  /// of g when every number changes by its last bit. Uses g_try_, u_try_, d_; one evaluation.
  bool at_floor();
  Value evaluate(const NodeArray& u, NodeArray& g, bool measure);
  void prepare_dynamics(const StepSettings& s);
  void start_where_inertia_leads(Value& value);
  enum class Search { moved, stuck };
  Search search(Value& value, double slope);
  double direction(const NodeArray& g, const std::function<void(const NodeArray&, NodeArray&)>& metric);
  double relative_residual() const;
  double next_move_mm(const std::function<void(const NodeArray&, NodeArray&)>& metric);  // distance_estimate.h
  void begin_or_end_untangling(Value& value, bool dynamic);
  bool every_piece_is_held() const;
  void give_metric_springs();
  void look_at_cells();    // what the metric lacks of them
  void show_hard_cells();  // to the metric, which has this model already
  void make_loads();
  void find_loose_pieces();  // where contacts could push them
  void drop_held(NodeArray& a) const { put_held(a, {}); }
  void put_held(NodeArray& a, const NodeArray& from) const;  // held components, zero from an empty array
  void publish();
  int pairs() const;  // of the history

  Engine engine_;
  bool augmented_;
  MinimiserPolicy own_;
  ComponentMetric metric_;
  std::shared_ptr<const FemModel> model_;
  std::unique_ptr<ElementSystem> elements_;
  std::vector<int32_t> fixed_;       // nodes that are held whole
  std::vector<int32_t> sliding_;     // nodes that are held along some axes
  std::vector<int32_t> of_slivers_;  // nodes of nearly empty cells only, beside fuller ones
  std::vector<int32_t> slivers_;     // cells with a node of of_slivers_
  std::vector<Spring> springs_;
  SpringForces forces_;
  std::vector<Preconditioner::SpringEntry> spring_rows_;  // of springs_
  StretchedCells stretched_;
  HardenedCells hardened_;
  int lagging_iterations_ = 0;  // with a large residual, since a hook moved or cells were looked at
  ContactForces contacts_;
  Vec3 gravity_m_s2_ = Vec3::Zero();
  std::vector<DeadLoad> load_list_;
  DeadLoads loads_;    // of both
  LoosePieces loose_;  // looked for when something could push one
  bool loose_known_ = false;
  MaterialPoints points_;
  ViscousPoints viscous_;
  LbfgsHistory history_;
  MetricScale scale_;
  double gamma_ = 1;              // of the direction in d_
  bool level_ = false;            // the last two energies could not be told apart
  LevelWatch level_watch_;        // since the solver was last given anything
  bool pairs_are_plain_ = false;  // the history tells of the plain energy

  NodeArray u_, g_, d_, u_try_, g_try_;
  NodeArray velocity_;                    // mm/s
  NodeArray u_base_, inertia_target_;     // U and t above
  NodeArray u_before_, velocity_before_;  // one step earlier, for BDF2
  double before_s_ = 0;                   // how much earlier; 0: no such step
  double h_s_ = 0;                        // of the step being made
  Vec3 fall_mm_ = Vec3::Zero();           // what weight adds to the target in free flight, g / (1/h^2 + c/h)
  std::vector<float> inertia_;            // per node, mN/mm; empty in a quasi-static step
  double force_scale_ = 0;                // sqrt(sum_nodes (sum of force magnitudes)^2), of the last measuring evaluate
  std::vector<std::array<double, 2>> floor_weight_;  // per stencil: shear modulus in kPa, area of a cell's side in mm2
  double force_floor_ = 0;      // the same for a strain of 1e-3, so that a block at rest has a scale too
  int tangled_iterations_ = 0;  // spent in steps that ended in a tangle, without a better one between
  bool untangling_ = false;
  int untangling_iterations_ = 0;
  DistanceEstimate distance_;
  int since_update_ = 0;  // accepted iterates since the multipliers changed
  std::vector<Vec3f> shown_;
};

}  // namespace limberg::fem
