#pragma once
// The patient under the knife: what a scene asked for, and nothing else.
//
//   World world(scene, workers);
//   world.apply(Incise{...});            // atomic: done, or refused with a reason and an unchanged hash
//   world.step(settings);                // one solver step; no thread, no clock
//   world.fill(snapshot);                // positions, hooks, sutures, residual
//
// The order of use inside: Body (geometry/) -> Arrangement (cutting/) -> LatticeTopology (lattice/) -> FemModel and
// ElasticSolver (fem/) -> SurfaceView embedded in the lattice -> Snapshot.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/body/body.h"
#include "sim/commands/command.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/patient/snapshot.h"

namespace limberg {

struct ContactCounts;  // contact/contact_counts.h
struct FaultPlan;
struct PressAnswer;  // press.h
struct PressQuestion;
struct LatticeTopology;
class Arrangement;

/// What World is built from; made by app/ from a scene file, or by a researcher's own code.
/// automatic: on where something has been cut that can touch.
enum class ContactChoice : uint8_t { automatic, on, off };

struct WorldSpec {
  std::shared_ptr<const Body> body;
  double cell_mm = 3.5;
  double suture_k_N_per_mm = 20;
  // a stitch holds the mean of its wound's edge over so much to either side; 0: one point of it
  double suture_bite_mm = 1;
  double hook_k_N_per_mm = 0.5;
  double suture_pull_mm_per_step = 0.5;  // how fast a stitch is drawn tight
  double region_mm = 0;  // > 0: tissue farther than this from the chart's origin holds still (lattice/region.h)
  bool can_cut = true;   // false: no cutter is built
  // cells in which a cut ends are divided twice, three times where it runs askew, so that it opens to within a quarter
  // cell of its end
  bool refine_fronts = false;
  bool refine_pockets = true;                  // with refine_fronts: at the rim of what is undermined too
  bool dynamic = false;                        // false: quasi-static
  ContactChoice contact = ContactChoice::off;  // do wound surfaces keep each other out? (contact/contact_finder.h)
  uint64_t seed = 1;
  FaultPlan* fault = nullptr;  // tests only: lets steps of a cut fail (cutting/fault.h)
};

class World {
 public:
  World(WorldSpec spec, Workers& workers);
  ~World();
  World(World&&) noexcept;

  Outcome apply(const Command& command);
  StepReport step(const StepSettings& settings);
  /// Takes what holds the tissue elsewhere: every fixed node to where(its place at rest), in mm. Free nodes stay where
  /// they are until the next step. Cuts keep it; undo goes back to how the tissue was held then.
  void hold_at(const std::function<Vec3(const Vec3& X_mm)>& where);
  /// Reuses the snapshot's memory. The tension field costs a few ms and is filled only when asked for.
  void fill(Snapshot& snapshot, bool with_field = false) const;
  std::shared_ptr<const SurfaceTopology> topology() const;
  /// How stiff the patient is against a tool that presses here (world/press_probe.h). Asking changes no bit of the
  /// patient.
  PressAnswer press(const PressQuestion& question, int iterations = 8);

  uint64_t topology_hash() const;  // same on every machine
  uint64_t state_hash() const;     // positions, topology, hooks and sutures
  /// The same and all that undo and redo bring back: the whole arrangement, the solver's velocities and pressures,
  /// counters. For tests; O(everything).
  uint64_t full_hash() const;

  // For measurement (sim/measure).
  const WorldSpec& spec() const;
  const ElasticSolver& solver() const;
  const Arrangement* arrangement() const;  // null when the scene cannot be cut
  std::shared_ptr<const LatticeTopology> lattice() const;
  double volume_mm3() const;          // exact, of all remaining pieces at rest
  double removed_volume_mm3() const;  // exact, of what was excised
  double initial_volume_mm3() const;
  int pieces() const;                    // connected pieces of the lattice
  int refused() const;                   // commands refused so far
  bool settled() const;                  // every stitch is drawn tight
  ContactCounts contact_counts() const;  // what contact has cost so far, counted
  /// Elastic energy, threads included, above that of the open wound: of the last state at rest (residual 1e-3) that
  /// neither hook nor stitch held. Nothing as long as there was none, or a hook still pulls. Cutting after it goes into
  /// the difference.
  std::optional<double> closure_energy_uJ() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
