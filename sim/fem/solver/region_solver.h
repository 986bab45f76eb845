#pragma once
// A solver for a part of a model: cells of scale 0 (lattice/region.h) and the nodes
// of no other cell are absent. They have no unknown, no element, no row of a matrix
// and no place in any vector; what the caller sees is the whole model all the same.
//
//   whole model   nodes and cells as the lattice numbers them: springs, contacts, displacements, cells' J
//   present       cells with scale > 0 and their nodes, in the order of the whole;
//                 made anew with every model, chunks of arrays that are as before
//                 shared. This is all that the minimiser (any ElasticSolver) ever sees
//   anchors       eight held nodes of no cell at the corners of the
//                 body's box, present nodes 0..7. A place in absent
//                 tissue is where it was at rest, and any such place is a
//                 sum of the eight with trilinear weights: so a hook or a
//                 stitch may hang on absent tissue like on any other
//
// The answer is that of the whole model with the absent nodes held, to rounding: the same
// energy of the same unknowns. What an absent node is given from outside (set_displacement_mm)
// is dropped: absent tissue is at rest. A saved state has the length of what is present.
#include <memory>

#include "sim/fem/solver/elastic_solver.h"

namespace limberg::fem {

class RegionSolver final : public ElasticSolver {
 public:
  explicit RegionSolver(std::unique_ptr<ElasticSolver> inner) : inner_(std::move(inner)) {}

  void set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent) override;
  void set_springs(std::span<const Spring> springs) override;
  void set_contacts(std::span<const Contact> contacts) override;
  void set_gravity(const Vec3& m_s2) override { inner_->set_gravity(m_s2); }
  Vec3 gravity_m_s2() const override { return inner_->gravity_m_s2(); }
  void set_loads(std::span<const DeadLoad> loads) override;
  std::span<const DeadLoad> loads() const override { return loads_; }
  StepReport step(const StepSettings& settings) override;
  void make_ready(const StepSettings& settings) override { inner_->make_ready(settings); }
  std::span<const Vec3f> displacement_mm() const override { return shown_; }
  void set_displacement_mm(std::span<const Vec3f> u) override;
  SolverState save() const override { return inner_->save(); }
  void restore(const SolverState& state) override;
  std::shared_ptr<const SolverPath> path() const override { return inner_->path(); }
  void take_up(const SolverPath& path) override { inner_->take_up(path); }
  std::span<const float> memory() const override { return inner_->memory(); }
  Vec3 spring_force_mN(int32_t id) const override { return inner_->spring_force_mN(id); }
  double contact_force_mN(size_t i) const override { return inner_->contact_force_mN(i); }
  Vec3 contact_friction_mN(size_t i) const override { return inner_->contact_friction_mN(i); }
  size_t contacts() const override { return inner_->contacts(); }
  /// Of present nodes; and those of the anchors, which are no nodes of the whole: node -1.
  std::vector<SupportForce> support_forces_mN() const override;
  Vec3 load_force_mN() const override { return inner_->load_force_mN(); }  // absent tissue has no weight
  void cell_J(std::vector<float>& J) const override;                       // 1 where absent
  Mat3 cell_F(int32_t cell) const override;
  std::string describe() const override;
  const FemModel& model() const override { return *whole_; }
  /// What the minimiser sees.
  const FemModel& present() const { return inner_->model(); }
  /// Per node and cell of that: its number in the whole; -1: an anchor.
  std::span<const int32_t> nodes() const { return node_at_; }
  std::span<const int32_t> cells() const { return cell_at_; }
  /// Whether a node or cell of the whole is there.
  bool holds_node(int32_t node) const { return place_[size_t(node)] >= 0; }
  bool holds_cell(int32_t cell) const { return cell_place_[size_t(cell)] >= 0; }

 private:
  EmbeddedPoint find(const EmbeddedPoint& p) const;
  void show();

  std::unique_ptr<ElasticSolver> inner_;
  std::shared_ptr<const FemModel> whole_;
  Vec3 low_mm_ = Vec3::Zero(), high_mm_ = Vec3::Zero();  // corners of the anchors' box, of the first model
  std::vector<int32_t> node_at_, cell_at_;               // present node or cell -> whole (anchors: -1)
  std::vector<int32_t> place_, cell_place_;              // whole -> present, -1: absent
  std::vector<DeadLoad> loads_;                          // on nodes of the whole
  std::vector<Vec3f> shown_;
};

}  // namespace limberg::fem

namespace limberg {

/// make_solver's for models of which a part is absent.
std::unique_ptr<ElasticSolver> make_region_solver(Workers& workers);

}  // namespace limberg
