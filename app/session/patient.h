#pragma once
// What the solver lane drives: World behind a narrow door, so
// that the lanes can be tested with a patient of a few lines.
#include <memory>

#include "app/session/lattice_shown.h"
#include "devices/hand_ground.h"
#include "sim/commands/command.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/patient/press.h"
#include "sim/patient/snapshot.h"

namespace limberg {

class Patient {
 public:
  virtual ~Patient() = default;
  virtual Outcome apply(const Command& command) = 0;
  virtual StepReport step(const StepSettings& settings) = 0;
  /// False while something that a command began is still going on over steps (a stitch that is being drawn tight).
  virtual bool settled() const { return true; }
  virtual void fill(Snapshot& snapshot) const = 0;
  /// With the tension of the skin, where the patient knows one.
  virtual void fill_with_field(Snapshot& snapshot) const { fill(snapshot); }
  /// How stiff it is against a tool that presses (sim/patient/press.h). Asking changes nothing. False: it cannot tell.
  virtual bool press(const PressQuestion&, PressAnswer&) { return false; }
  /// What its body knows of touched places; null: no body of skin. Lives as long as the patient.
  virtual const HandGround* ground() const { return nullptr; }
  /// How many pieces of bone there are; -1: it has no bone.
  virtual int pieces_of_bone() const { return -1; }
  /// The lattice, where the patient has one.
  virtual void fill_lattice(LatticeShown& out) const { out = {}; }
  virtual std::shared_ptr<const SurfaceTopology> topology() const = 0;
  virtual uint64_t topology_hash() const = 0;
  virtual uint64_t state_hash() const = 0;
};

}  // namespace limberg
