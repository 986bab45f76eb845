#pragma once
// One minimiser for quasi-static and implicit dynamic steps: L-BFGS on a scalar preconditioner, history kept between
// frames, augmented-Lagrangian pressure per cell. Knows models, springs and time steps; nothing of skin or cuts.
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "sim/base/workers.h"
#include "sim/fem/model/fem_model.h"

namespace limberg {

/// How a dynamic step replaces time derivatives. Both are unconditionally stable on linear problems; backward Euler is
/// of first order and damps every motion, BDF2 is of second order and damps the slow ones far less. BDF2 begins with
/// one step of backward Euler, and again after a change of dt_s, a displacement from outside, or steps of another kind.
enum class Integrator : uint8_t { backward_euler, bdf2 };

struct StepSettings {
  int max_iterations = 10;
  double tolerance = 0;  // stop when the relative residual is below; 0 = use all iterations
  double dt_s = 0;       // 0 = quasi-static; otherwise one step of `integrator`
  Integrator integrator = Integrator::backward_euler;
  double damping_per_s = 0;  // mass-proportional, dynamic steps only
  // What the iterations before have found is forgotten: how this step goes on depends on the state and path() alone.
  bool afresh = false;
  bool focus = false;  // only what is near to what a hand carries need be solved for while it is carried (FocusSolver)
  // > 0: stop after the iterate that has gone farther than this from the start, slivers' nodes aside
  double most_move_mm = 0;
  double budget_ms = 0;               // 0 = none. Not used by the solver itself (it reads no clock): see should_stop
  std::function<bool()> should_stop;  // asked after each iteration; empty = never
  int adopt_after_steps = 3;          // a pending preconditioner is waited for after so many steps (deterministic)...
  bool adopt_when_ready = false;      // ...or taken as soon as it is there (real time)
  // With adopt_when_ready: asked at each such chance, told whether it is there;
  // true: it is taken (and waited for if need be). So a step that was taken against
  // the clock can be taken again, bit for bit. Empty: it is taken when it is there.
  std::function<bool(bool there)> adopt_now;
};

struct StepReport {
  int iterations = 0;
  // |g| / |s| in the Euclidean norm over free nodes: g = net force on a
  // node, s = sum of the norms of the forces that meet there (each
  // cell's share, springs', inertia), plus what a strain of 0.1 % would
  // give, so that rest has a scale. Single precision reaches about 1e-6.
  double residual = 0;
  // estimated distance to equilibrium of the node that is farthest off (distance_estimate.h): of two hundred frames one
  // is more than three times farther off; at the median a quarter of what is stated is left
  double distance_mm = 0;
  double energy_uJ = 0;    // with loads, what they have done is taken off: - sum of force . displacement
  bool converged = false;  // residual <= tolerance
  bool stalled = false;    // given up before max_iterations: more of them gain nothing (stall_watch.h); not converged
  bool at_floor = false;   // stalled, and why: the residual is what the last bits of single precision make of it
  bool preconditioner_pending = false;
  bool metric_is_cycle = false;  // the multilevel cycle was used, not a factor of this very model
  int inverted_cells = 0;
  double min_J = 1;
};

/// What a solver must get back to stand where it stood (its springs are the caller's). In the node and cell order of
/// its model; lists that would hold nothing but zeros are empty.
struct SolverState {
  std::vector<float> displacement_mm, velocity_mm_s;  // 3 per node
  std::vector<float> pressure;                        // 1 per cell: the multiplier of its volume
  int since_update = 0;                               // iterates since the multipliers changed
  // One step earlier, for BDF2; before_s is the time between, 0 when there is no such step.
  std::vector<float> displacement_before_mm, velocity_before_mm_s;
  double before_s = 0;
  std::vector<float> memory;  // of layers that relax (viscous_points.h)
  bool operator==(const SolverState&) const = default;
};

/// What a held node receives from the material, from springs and contacts that hang on it, and from its own weight and
/// loads: its support gives the opposite. Zero along axes that are not held.
struct SupportForce {
  int32_t node = -1;
  Vec3 force_mN = Vec3::Zero();
};

/// By which way a solver goes on from a state: what its metric was made from and has learned. Some numbers per node.
struct SolverPath {
  virtual ~SolverPath() = default;
};

class ElasticSolver {
 public:
  virtual ~ElasticSolver() = default;

  /// Takes a new model: positions, velocities and pressures are carried through FemModel::parent and
  /// `cell_parent` (per cell: index in the previous model); the factorization is rebuilt in the background.
  virtual void set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent) = 0;

  /// The whole list of springs, in any order, ids unique. Moving a target costs
  /// nothing; adding or removing a spring never waits for a factorization. Springs name
  /// nodes of the current model: give them again after set_model, which drops them.
  virtual void set_springs(std::span<const Spring> springs) = 0;

  /// The whole list of contacts; an empty list costs nothing. They hold until the next list or the next model.
  virtual void set_contacts(std::span<const Contact> contacts) = 0;

  /// Weight, in m/s^2 along the axes of the model: every node is drawn with its FemModel::mass_kg times this. Zero, as
  /// at first, costs nothing. It stays through set_model, with the masses of the new model. The shape X_mm is the one
  /// without load: the tissue sags from it. In a quasi-static step a piece that neither a held component nor a spring
  /// holds along an axis has no weight and no load along it: there is no place where it would rest. In a dynamic step
  /// it falls. InputError: not finite.
  virtual void set_gravity(const Vec3& m_s2) = 0;
  virtual Vec3 gravity_m_s2() const = 0;

  /// The whole list of loads. They name nodes of the current model: give them again after set_model, which drops them.
  /// InputError: a load without a place, of another model, or not finite.
  virtual void set_loads(std::span<const DeadLoad> loads) = 0;
  virtual std::span<const DeadLoad> loads() const = 0;

  virtual StepReport step(const StepSettings& settings) = 0;
  /// Makes now what the next step with these settings would begin with, so that others can work beside it. That step
  /// is the same to the last bit.
  virtual void make_ready(const StepSettings&) {}

  virtual std::span<const Vec3f> displacement_mm() const = 0;      // per node: x - X
  virtual void set_displacement_mm(std::span<const Vec3f> u) = 0;  // tests, undo; fixed nodes stay where this puts them
  /// For undo and redo: the same bits come back, the same model given. The memory
  /// of past iterates is not kept: only the path of the next iterations depends on
  /// it, not where they lead. restore throws InputError on lists of another model.
  virtual SolverState save() const = 0;
  virtual void restore(const SolverState& state) = 0;
  /// After restore, so that the iterations that follow are those that would have followed then, to the last bit, if
  /// they begin afresh (StepSettings).
  virtual std::shared_ptr<const SolverPath> path() const { return {}; }
  virtual void take_up(const SolverPath&) {}
  /// What layers that relax remember (SolverState::memory), without a copy; empty when nothing relaxes.
  virtual std::span<const float> memory() const { return {}; }
  Vec3 position_mm(const EmbeddedPoint& p) const;
  /// Force in mN that the spring exerts on its point a.
  virtual Vec3 spring_force_mN(int32_t id) const = 0;
  /// Force in mN of the i-th contact of the list, along its normal; never negative.
  virtual double contact_force_mN(size_t i) const = 0;
  virtual Vec3 contact_friction_mN(size_t i) const = 0;  // on its point a, across its normal
  virtual size_t contacts() const = 0;                   // length of the list
  /// Of every node that is held, ascending. At rest sum f_support = sum of hooks' forces + load_force_mN().
  virtual std::vector<SupportForce> support_forces_mN() const = 0;
  /// Their sum.
  Vec3 support_force_mN() const;
  /// Sum of weight and loads as they act in a step of the kind made last (at first: quasi-static), those of held nodes
  /// included.
  virtual Vec3 load_force_mN() const = 0;
  /// J = det F of each cell, where its volume is sampled (fem_model.h:
  /// the centre, unless layers of one side only share it).
  virtual void cell_J(std::vector<float>& J) const = 0;
  /// Deformation gradient at the sample point of a cell (row-major meaning F(i,j) = dx_i/dX_j).
  virtual Mat3 cell_F(int32_t cell) const = 0;
  /// Bytes in use and time spent belong to the caller's benches; this is what was chosen, in words.
  virtual std::string describe() const = 0;

  virtual const FemModel& model() const = 0;
};

std::unique_ptr<ElasticSolver> make_solver(Workers& workers);

}  // namespace limberg
