#pragma once
// Everything of one patient, in the order of dependence, and the surgical actions on it.
//
// An action is atomic. A cut goes blade -> arrangement -> lattice -> finite elements -> surface; whatever refuses on the
// way, all before it is taken back. Each cut keeps what undo needs: the versions it replaced, and the displacements.
// Hooks and stitches are springs; a stitch is drawn tight over some steps (its slack shrinks), as a hand does it.
#include <memory>
#include <string>
#include <vector>

#include "sim/cutting/arrangement.h"
#include "sim/cutting/blade_build.h"
#include "sim/geometry/skin.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/topology.h"
#include "sim/world.h"
#include "sim/world/anchors.h"
#include "sim/world/rest_index.h"
#include "sim/world/tension_field.h"

namespace limberg {

class OperatingTable {
 public:
  OperatingTable(WorldSpec spec, Workers& workers);

  Outcome apply(const Command& command);
  StepReport step(const StepSettings& settings);
  void fill(Snapshot& snapshot, bool with_field) const;

  std::shared_ptr<const SurfaceTopology> topology() const { return version_.surface; }
  uint64_t state_hash() const;
  const WorldSpec& spec() const { return spec_; }
  const ElasticSolver& solver() const { return *solver_; }
  double volume_mm3() const { return volume_mm3_; }
  double removed_volume_mm3() const { return removed_volume_mm3_; }
  double initial_volume_mm3() const { return initial_volume_mm3_; }
  int pieces() const { return version_.lattice->pieces; }
  int refused() const { return refused_; }
  bool settled() const;  // every stitch drawn tight

 private:
  /// One state of the topology; immutable once made.
  struct Version {
    std::shared_ptr<const LatticeTopology> lattice;
    std::shared_ptr<const FemModel> model;
    std::shared_ptr<const SurfaceTopology> surface;
    std::shared_ptr<const RestIndex> index;
  };
  /// What undo takes back: a cut (with everything that it replaced), or stitches.
  struct Done {
    bool is_cut = false;
    Version before;
    int arrangement_steps = 0;  // operations of the arrangement: 1 for a cut, 2 for an excision
    std::vector<Vec3f> displacement;
    std::vector<Hook> hooks;
    std::vector<Stitch> stitches;
    double volume_mm3 = 0, removed_volume_mm3 = 0;
  };

  Outcome act(const Incise&);
  Outcome act(const Undermine&);
  Outcome act(const Excise&);
  Outcome act(const SetHook&);
  Outcome act(const MoveHook&);
  Outcome act(const ReleaseHook&);
  Outcome act(const Suture&);
  Outcome act(const SutureRow&);
  Outcome act(const Undo&);
  Outcome act(const Stage&);
  Outcome act(const Wait&);

  Outcome cut(const BladeResult& blade, bool take_out, const Vec3& inside_mm);
  Outcome rebuild();  // lattice, model, surface, anchors after the arrangement has changed
  std::shared_ptr<const SurfaceTopology> make_surface(const LatticeTopology& lattice);
  std::optional<SurfacePoint> find_skin(const ChartPoint& p, std::string& reason) const;
  std::optional<Anchor> find_anchor(const ChartPoint& p, bool on_rim, std::string& reason) const;
  EmbeddedPoint embed(const Anchor& anchor) const;
  bool carry_anchors();  // true when something was lost with its tissue
  bool same_place(const Anchor& a, const Anchor& b) const;
  bool joins(const Stitch& stitch, const Anchor& a, const Anchor& b) const;  // the same two places, either way round
  void publish_springs();
  BladeContext blade_context() const;
  Done remember(bool is_cut, int arrangement_steps) const;
  Vec3 position_mm(const EmbeddedPoint& e) const { return solver_->position_mm(e); }

  WorldSpec spec_;
  std::shared_ptr<const Body> body_;
  Skin skin_;
  std::unique_ptr<Arrangement> arrangement_;  // absent when the scene cannot be cut
  std::unique_ptr<StencilTable> stencils_;
  Version version_;
  std::unique_ptr<ElasticSolver> solver_;
  std::vector<Hook> hooks_;
  std::vector<Stitch> stitches_;
  std::vector<Done> done_;
  std::vector<float> depth_of_point_mm_;  // by arrangement point; points never move
  mutable std::unique_ptr<TensionField> tension_;
  mutable uint64_t tension_version_ = 0;
  double initial_volume_mm3_ = 0, volume_mm3_ = 0, removed_volume_mm3_ = 0;
  uint64_t steps_ = 0, cuts_ = 0;
  uint64_t next_version_ = 1;
  int32_t next_spring_ = 1, next_stitch_ = 1, stage_ = -1;
  int refused_ = 0;
  float residual_ = 0, distance_mm_ = 0;
};

}  // namespace limberg
