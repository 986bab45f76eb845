#pragma once
// An operation script carried out without a hand: each action straight to the
// patient, then steps until it is at rest. The same script at another cell size is
// the same operation: that is how a result's dependence on the lattice is shown.
#include <functional>
#include <string>
#include <vector>

#include "app/assembly/world_patient.h"
#include "app/scene/scene.h"
#include "app/session/story.h"
#include "sim/commands/script.h"

namespace limberg {

struct OperationSettings {
  double hook_step_mm = 2;       // a hook moves by so much between solver steps
  int iterations = 20;           // of one solver step
  double rest_residual = 2e-5;   // at rest after an action
  int rest_steps = 100;          // at most so many steps towards it
  double final_residual = 1e-5;  // at the end; single precision reaches about 4e-6
  int final_steps = 400;
  std::function<void(const ScriptLine& line, const std::string& note)>
      on_done;  // note: what is worth knowing, mostly nothing
  std::function<void(const Command& command, const std::string& reason)> on_refusal;  // before the InputError
  std::function<bool()> interrupted;
  bool keep_going = false;  // an action that is refused is told and left out; else it ends the operation
  std::function<void(size_t done, size_t total)> progress;
};

/// What the stitches pulled with when an action had come to rest.
struct ClosureForce {
  int line = 0;  // of the script
  std::string action;
  double sum_N = 0, max_N = 0;
  int stitches = 0, max_id = 0;
};

/// An action that the patient refused.
struct RefusedAction {
  int line = 0;  // of the script
  std::string action, reason;
};

struct OperationOutcome {
  std::vector<ClosureForce> closure;  // after every action that came while or after something was sewn
  std::vector<StageRow> stages;       // t_s: number of the script's line, not a time
  SolverSeries series;                // t_s: number of the solver step
  StepReport last;
  bool stalled = false;                // on the last way to rest more iterations gained nothing (stall_watch.h)
  double solve_ms = 0;                 // wall time of all solver steps
  int64_t iterations = 0;              // of the minimiser, in all of them
  size_t cells = 0;                    // lattice cells that held material before the first cut
  size_t done = 0;                     // actions that were carried out
  std::vector<RefusedAction> refused;  // with keep_going
  bool interrupted = false;            // the patient is as it was then, and may not be at rest
};

/// On any patient. InputError with the script's file and line when it refuses an action, unless it is to keep going.
OperationOutcome operate(Patient& patient, const Script& script, const OperationSettings& settings);
/// The same on a patient of skin, whose cells are counted.
OperationOutcome operate(World& world, double max_depth_mm, const Script& script, const OperationSettings& settings);

}  // namespace limberg
