#pragma once
// A head as the session drives it; where the scene has a body too, one patient: skin with flap tools over bone that
// moves.
//
// The skin's fixed nodes that lie at most `carries_skin_mm` from a bone at rest go where their bone goes, as Dirichlet
// values of the finite elements; so a fragment that is moved pulls the skin that is attached to it. Undo and redo go to
// whichever of the two acted last.
#include <memory>
#include <vector>

#include "app/assembly/world_patient.h"
#include "app/session/patient.h"
#include "sim/skull/head/head.h"

namespace limberg {

class HeadPatient final : public Patient {
 public:
  /// `skin`: null where there is none. dt_s: of one step, for fragments that are held.
  HeadPatient(Head& head, World* world, double max_depth_mm, double dt_s, double carries_skin_mm);

  Outcome apply(const Command& command) override;
  /// residual: of the skin; of a face that is not at rest, how far it moved in the last iteration in mm, at least
  /// kMoving.
  StepReport step(const StepSettings& settings) override;
  bool settled() const override { return !skin_ || skin_->settled(); }
  void fill(Snapshot& snapshot) const override { fill(snapshot, false); }
  void fill_with_field(Snapshot& snapshot) const override { fill(snapshot, true); }
  void fill_lattice(LatticeShown& out) const override {
    if (skin_)
      skin_->fill_lattice(out);
    else
      out = {};
  }
  /// Of the skin. Bone and face are not asked for: false.
  bool press(const PressQuestion& question, PressAnswer& answer) override;
  std::shared_ptr<const SurfaceTopology> topology() const override;
  uint64_t topology_hash() const override;
  uint64_t state_hash() const override;

  static constexpr double kMoving = 2e-4;

 private:
  enum class By : uint8_t { head, skin };
  void fill(Snapshot& snapshot, bool with_field) const;
  void carry_skin();
  Outcome go_back(const Command& command, std::vector<By>& from, std::vector<By>& to);

  Head& head_;
  World* world_;
  std::unique_ptr<WorldPatient> skin_;
  double dt_s_, carries_skin_mm_;
  std::vector<By> done_, undone_;
  int stroke_ = 0;  // the incision in pieces that is the last entry
  // Of the skin's fixed nodes, by their number: the fragment that carries them, -1 none.
  uint64_t carried_world_ = 0, carried_bones_ = 0;
  std::vector<std::pair<Vec3, int32_t>> carrier_;  // place at rest, fragment; in the order in which World asks
  bool stale_ = true;
  std::vector<Eigen::Isometry3d> poses_;
  // The two surfaces as one.
  mutable std::shared_ptr<const SurfaceTopology> of_skin_, of_head_, both_;
  mutable uint64_t version_ = 0;
  mutable Snapshot bone_;
};

}  // namespace limberg
