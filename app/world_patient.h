#pragma once
// World as the session drives it.
#include "app/session/patient.h"
#include "sim/world.h"

namespace limberg {

class WorldPatient final : public Patient {
 public:
  explicit WorldPatient(World& world) : world_(world) {}
  Outcome apply(const Command& c) override { return world_.apply(c); }
  StepReport step(const StepSettings& s) override { return world_.step(s); }
  void fill(Snapshot& s) const override { world_.fill(s); }
  std::shared_ptr<const SurfaceTopology> topology() const override { return world_.topology(); }
  uint64_t topology_hash() const override { return world_.topology_hash(); }
  uint64_t state_hash() const override { return world_.state_hash(); }

 private:
  World& world_;
};

}  // namespace limberg
