#pragma once
// A patient (sim/patient/world.h) as the session drives it, with the scene's own limits.
#include "app/session/patient.h"
#include "sim/patient/world.h"

namespace limberg {

class WorldPatient final : public Patient, private HandGround {
 public:
  WorldPatient(World& world, double max_depth_mm) : world_(world), max_depth_mm_(max_depth_mm) {}
  /// Refuses cuts deeper than the scene allows; everything else is World's own judgement.
  Outcome apply(const Command& c) override;
  StepReport step(const StepSettings& s) override { return world_.step(s); }
  bool settled() const override { return world_.settled(); }
  bool press(const PressQuestion& q, PressAnswer& a) override { return a = world_.press(q), a.stiffness_N_mm > 0; }
  const HandGround* ground() const override { return world_.skin() ? this : nullptr; }
  void fill(Snapshot& s) const override { world_.fill(s); }
  void fill_with_field(Snapshot& s) const override { world_.fill(s, true); }
  int pieces_of_bone() const override;
  void fill_lattice(LatticeShown& out) const override;
  std::shared_ptr<const SurfaceTopology> topology() const override { return world_.topology(); }
  uint64_t topology_hash() const override { return world_.topology_hash(); }
  uint64_t state_hash() const override { return world_.state_hash(); }

 private:
  bool chart_means(const ChartPoint& place, const Vec3& X_mm) const override;
  Vec3 normal(const Vec3& X_mm) const override;
  bool margin_beyond(const Vec3& X_mm, const Vec3& out, const Vec3& way) const override;

  World& world_;
  double max_depth_mm_;
  mutable LatticeShown lattice_;  // its edges, while they hold
};

}  // namespace limberg
