#pragma once
// While a hand carries something only the tissue around it is solved for, as far as an error budget allows.
//
//   whole   the solver of the whole model: alone at work while nothing is carried
//   near    a solver for the part within a reach of what is carried and of what moves with it, with every stitch and
//           contact (RegionSolver); the rest holds still where it is
//
//   begins  when a spring's target has moved: a hook is carried, a stitch drawn
//   error   what holds still would move, too. By how far says the metric of the whole of the forces that the rim bears
//           more than when it was held first: one application, in the first step and every few after it. Beyond the
//           budget the whole takes a step, and the next part begins from there. It reaches farther where that came too
//           soon, and waits a while where it came at once, or where a move would go far from the beginning
//   ends    when near is at rest or nothing has been carried for a while, and with other springs, another model or an
//           undo: the whole takes over what near has found, and brings all of it to rest. So the answer at rest is that
//           of the whole model
//
// How it goes on depends on what it was given alone, so that a session is played again bit for bit. Only quasi-static
// steps that ask for it (StepSettings::focus), of models with many nodes and without loads; all others are the whole's.
#include <limits>
#include <memory>
#include <set>

#include "sim/fem/solver/focus_settings.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "sim/fem/solver/region_solver.h"

namespace limberg::fem {

class FocusSolver final : public ElasticSolver {
 public:
  explicit FocusSolver(Workers& workers, FocusSettings settings = {});

  void set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent) override;
  void set_springs(std::span<const Spring> springs) override;
  void set_contacts(std::span<const Contact> contacts) override;
  void set_gravity(const Vec3& m_s2) override;
  Vec3 gravity_m_s2() const override { return whole_->gravity_m_s2(); }
  void set_loads(std::span<const DeadLoad> loads) override;
  std::span<const DeadLoad> loads() const override { return whole_->loads(); }
  StepReport step(const StepSettings& settings) override;
  void make_ready(const StepSettings& settings) override {
    if (!on_) whole_->make_ready(settings);
  }
  std::span<const Vec3f> displacement_mm() const override;
  void set_displacement_mm(std::span<const Vec3f> u) override;
  SolverState save() const override;
  void restore(const SolverState& state) override;
  std::shared_ptr<const SolverPath> path() const override;
  void take_up(const SolverPath& path) override { whole_->take_up(path); }
  std::span<const float> memory() const override { return whole_->memory(); }
  Vec3 spring_force_mN(int32_t id) const override;
  double contact_force_mN(size_t i) const override;
  Vec3 contact_friction_mN(size_t i) const override;
  size_t contacts() const override { return contacts_.size(); }
  std::vector<SupportForce> support_forces_mN() const override;
  Vec3 load_force_mN() const override { return whole_->load_force_mN(); }
  void cell_J(std::vector<float>& J) const override;
  Mat3 cell_F(int32_t cell) const override;
  std::string describe() const override;
  const FemModel& model() const override { return whole_->model(); }

  bool focused() const { return on_; }
  const LbfgsSolver& whole() const { return *whole_; }
  /// Of steps taken near: how many, and the most nodes that were not held.
  uint64_t steps_near() const { return steps_near_; }
  size_t most_nodes_near() const { return most_nodes_; }
  /// By how far what holds still would move, as estimated last; 0 where nothing is held.
  double held_back_mm() const { return on_ ? rim_mm_ : 0; }

 private:
  bool may_focus(const StepSettings& s) const;
  void enter(const StepSettings& s);
  std::vector<uint8_t> outside() const;  // per node: 1 where it would hold still
  bool covers(const EmbeddedPoint& p) const;
  void show();
  void leave();
  void forget();           // the part, and what it was chosen by
  void hand_over() const;  // what near has found, to the whole; it may go on
  double look_at_rim();

  FocusSettings set_;
  Workers& workers_;
  std::unique_ptr<LbfgsSolver> whole_;
  std::unique_ptr<RegionSolver> near_;  // of the last part of this model; may be taken again
  std::vector<uint8_t> out_;            // of it
  std::vector<SupportForce> rim_;       // what it bore when it was held
  bool on_ = false;
  mutable bool behind_ = false;  // the whole knows less than near
  std::vector<Spring> springs_;  // as given last, by id
  std::set<int32_t> carried_;    // springs whose targets have moved while something was carried
  std::vector<Contact> contacts_;
  std::vector<Vec3f> shown_;  // while focused
  std::vector<Vec3f> calm_;   // displacement when the whole was at rest last, or its first
  double reach_mm_;
  int unmoved_steps_ = std::numeric_limits<int>::max() / 2;  // since a spring's target has moved
  int wait_steps_ = 0;                                       // until a part is looked for again that was too large
  bool whole_first_ = false;                                 // the whole has a step to take before the next part
  double rim_mm_ = 0, rim_most_mm_ = 0;
  int steps_here_ = 0;  // near, since it was focused
  int look_at_ = 1;     // the step near in which the rim is looked at next
  double energy_beyond_uJ_ = 0;
  StepReport of_whole_;
  int inverted_beyond_ = 0;
  uint64_t steps_near_ = 0;
  size_t most_nodes_ = 0;
};

}  // namespace limberg::fem

namespace limberg {

std::unique_ptr<ElasticSolver> make_focus_solver(Workers& workers, const fem::FocusSettings& settings = {});

}  // namespace limberg
