#pragma once
// One patient under the knife: soft tissue with flap tools, a head of bones and face, or skin over bone that moves.
//
//   World world(spec, workers);          // or with a head: World world(skin, head, settings)
//   world.apply(Incise{...});            // atomic: done, or refused with a reason and an unchanged hash
//   world.step(settings);                // one step of every part; no thread, no clock
//   world.fill(snapshot);                // positions, hooks, sutures, residual
//
// Each part (soft_tissue.h, skull/head/head.h) carries out its own acts and returns what takes them back; the one
// history is kept here. Undo and redo take the last act, whichever part it was of. What undo of soft tissue brings back
// is all of the soft tissue as it was just before the act, hooks included.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/commands/command.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/patient/snapshot.h"
#include "sim/patient/world_spec.h"

namespace limberg {

struct HeadParts;    // skull/head/head.h
struct PressAnswer;  // press.h
struct PressQuestion;
class Head;
class SoftTissue;

struct HeadSettings {
  double dt_s = 1.0 / 60;      // of one step, for fragments that are held
  double carries_skin_mm = 0;  // fixed nodes of the soft tissue this near to a bone go with it (carried_skin.h)
};

class World {
 public:
  World(WorldSpec spec, Workers& workers);
  World(HeadParts parts, Workers& workers, const HeadSettings& settings = {});
  World(WorldSpec spec, HeadParts parts, Workers& workers, const HeadSettings& settings);
  ~World();
  World(World&&) noexcept;

  Outcome apply(const Command& command);
  /// Residual: of the skin; of a face that is not at rest, how far it moved in the last iteration in mm, at least
  /// kMoving.
  StepReport step(const StepSettings& settings);
  static constexpr double kMoving = 2e-4;
  /// Reuses the snapshot's memory. The tension field costs a few ms and is filled only when asked for.
  void fill(Snapshot& snapshot, bool with_field = false) const;
  std::shared_ptr<const SurfaceTopology> topology() const;
  /// How stiff the soft tissue is against a tool that presses here (press_probe.h). Asking changes no bit of the
  /// patient. Bone, face, and a place on another version of the surface: stiffness 0.
  PressAnswer press(const PressQuestion& question, int iterations = 8);
  /// The soft tissue, which must be there, is held elsewhere (soft_tissue.h).
  void hold_at(const std::function<Vec3(const Vec3& X_mm)>& where);
  bool settled() const;  // every stitch is drawn tight

  uint64_t topology_hash() const;  // same on every machine
  uint64_t state_hash() const;     // positions, topology, hooks and sutures
  /// Over all that undo and redo bring back: the whole arrangement, the solver's velocities and pressures, counters.
  /// For tests; O(everything).
  uint64_t full_hash() const;
  int refused() const { return refused_; }  // commands refused so far

  // The parts, to be measured; null: there is none.
  const SoftTissue* skin() const { return skin_.get(); }
  const Head* head() const { return head_.get(); }

 private:
  Outcome act(const Command& command);
  Outcome undo();
  Outcome redo();

  struct Past;    // the history
  struct Joined;  // what skin over bone needs
  std::unique_ptr<SoftTissue> skin_;
  std::unique_ptr<Head> head_;
  std::unique_ptr<Past> past_;
  std::unique_ptr<Joined> joined_;
  double dt_s_ = 0;
  uint64_t steps_ = 0;
  int stage_ = -1, refused_ = 0;
};

}  // namespace limberg
