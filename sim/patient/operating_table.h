#pragma once
// Everything of one patient, in the order of dependence, and the surgical actions on it.
//
// An action is atomic. A cut goes blade -> arrangement -> lattice -> finite elements -> surface; whatever refuses on
// the way, all before it is taken back.
//
// Undo and redo go between moments. A moment is everything of the patient but the arrangement: the version of the
// topology, the solver's state, hooks, stitches, counters. Undo keeps the moment that it leaves, so redo returns to
// exactly that one. The arrangement takes its operations back, and makes them again from what it was given: the same
// blade, seed and try give the same bits, which is checked.
//
// An incision may come in pieces while it is drawn (drawn_stroke.h); they are cut one by one and undone as one.
// Hooks and stitches are springs; a stitch is drawn tight over some steps (its slack shrinks), as a hand does it. A
// running suture is one thread through many bites, which slides until its tension is the same everywhere
// (fem/spring_forces.h).
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/body/skin.h"
#include "sim/contact/contact_counts.h"
#include "sim/contact/contact_memory.h"
#include "sim/cutting/arrangement/arrangement.h"
#include "sim/cutting/strokes/blade_build.h"
#include "sim/cutting/strokes/drawn_stroke.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/topology.h"
#include "sim/patient/anchors.h"
#include "sim/patient/point_depths.h"
#include "sim/patient/press_probe.h"
#include "sim/patient/rest_index.h"
#include "sim/patient/rim_walk.h"
#include "sim/patient/tension_field.h"
#include "sim/patient/world.h"

namespace limberg {

/// The smallest loose piece that counts as tissue.
inline constexpr double kDebris_mm3 = 1;

class ContactFinder;  // contact/contact_finder.h

class OperatingTable {
 public:
  OperatingTable(WorldSpec spec, Workers& workers);
  ~OperatingTable();

  Outcome apply(const Command& command);
  StepReport step(const StepSettings& settings);
  void hold_at(const std::function<Vec3(const Vec3& X_mm)>& where);
  void fill(Snapshot& snapshot, bool with_field) const;
  PressAnswer press(const PressQuestion& question, int iterations);

  std::shared_ptr<const SurfaceTopology> topology() const { return version_.surface; }
  uint64_t state_hash() const;
  uint64_t topology_hash() const;  // O(cells) once per version
  const WorldSpec& spec() const { return spec_; }
  const ElasticSolver& solver() const { return *solver_; }
  double volume_mm3() const { return volume_mm3_; }
  double removed_volume_mm3() const { return removed_volume_mm3_; }
  double initial_volume_mm3() const { return initial_volume_mm3_; }
  int pieces() const { return version_.lattice->pieces; }
  int refused() const { return refused_; }
  uint64_t full_hash() const;
  const Arrangement* arrangement() const { return arrangement_.get(); }
  std::shared_ptr<const LatticeTopology> lattice() const { return version_.lattice; }
  bool settled() const;  // every stitch drawn tight
  ContactCounts contact_counts() const;
  std::optional<double> closure_energy_uJ() const;

 private:
  /// One state of the topology; immutable once made. Versions share what they have in common, so all of them are kept.
  struct Version {
    std::shared_ptr<const LatticeTopology> lattice;
    std::shared_ptr<const FemModel> model;
    std::shared_ptr<const SurfaceTopology> surface;
    std::shared_ptr<const RestIndex> index;
    SharedArray<uint8_t> on_skin;  // point_depths.h
    uint64_t arrangement_hash = 0;
  };
  /// All that undo and redo bring back, except the arrangement.
  struct Moment {
    Version version;
    SolverState solver;
    ContactMemory contacts;
    std::vector<Hook> hooks;
    std::vector<Stitch> stitches;
    std::vector<Thread> threads;
    double volume_mm3 = 0, removed_volume_mm3 = 0;
    std::optional<double> open_energy_uJ;
    uint64_t cuts = 0;
    int32_t next_spring = 1, next_stitch = 1, next_thread = 1;
  };
  /// One cut of the arrangement with what went with it: enough to make it again.
  struct CutStep {
    Blade blade;  // empty: it only takes something out
    uint64_t seed = 0;
    int first_try = 0;
    int32_t excised = -1;  // the component that was taken out afterwards
    int operations = 1;    // of the arrangement
    uint64_t hash_after = 0;
    DebrisResult debris;   // what the cut left loose and was swept with it
    double taken_mm3 = 0;  // volume of the excised component
  };
  /// What undo takes back: a cut, an excision, or stitches (no steps).
  struct Done {
    Moment before;
    std::vector<CutStep> steps;
    ParentList ancestor;  // per node after it: the node before; empty when the lattice is the same
  };
  struct Undone {
    Done done;
    Moment after;
  };
  /// An incision that is being drawn. Its pieces are one entry of the history, the last one.
  struct Stroke {
    int id = 0;
    DrawnStroke drawn;
    bool cut = false;  // it has its entry
  };

  Outcome act(const Incise&);
  Outcome act(const InciseMore&);
  Outcome act(const Undermine&);
  Outcome act(const Excise&);
  Outcome act(const SetHook&);
  Outcome act(const MoveHook&);
  Outcome act(const ReleaseHook&);
  Outcome act(const Suture&);
  Outcome act(const SutureRow&);
  Outcome act(const SutureCorner&);
  Outcome act(const SutureBetween&);
  Outcome act(const CutSuture&);
  Outcome act(const Undo&);
  Outcome act(const Redo&);
  Outcome act(const Stage&);
  Outcome act(const Wait&);
  Outcome act(const HeadCommand&);

  Outcome cut(const BladeResult& blade, bool take_out, const Vec3& inside_mm);
  /// The cuts of one stroke on the arrangement alone; refused: nothing has changed.
  CutResult cut_stroke(const std::vector<ChartPoint>& path, double depth_mm, double angle_deg, bool spline,
                       std::vector<CutStep>& steps);
  /// What follows the cuts of one act: lattice, model and surface anew, and an entry in the history; or all is taken
  /// back.
  Outcome finish(Done done);
  /// Blade, excision and sweeping on the arrangement alone; refused: nothing has changed.
  Outcome cut_arrangement(const Blade& blade, bool take_out, const Vec3& inside_mm, CutStep& step, CutResult& made);
  /// What of the stroke that is being drawn can be cut by now; refused: nothing has changed.
  Outcome cut_on(bool last);
  Outcome stop_stroke(int stroke, const std::string& why);  // the rest of it will be refused
  bool cut_again(const CutStep& step);  // false, with nothing changed, when other bits came of it: a defect
  void take_back(std::span<const CutStep> steps);
  Outcome rebuild();  // lattice, model, surface, anchors after the arrangement has changed
  /// Lets followed_ catch up with the arrangement. Called between a cut and what is taken away after it, and before the
  /// next cut: an update that sees only one of the two names every parent exactly, one that sees both may not
  /// (topology.h).
  Outcome follow();
  /// What is drawn of the arrangement, and the index for picking; from those of version_ when there are some. Reads
  /// only what the lattice's update reads, too, so both may run at once.
  struct Drawn {
    std::shared_ptr<SurfaceTopology> surface;
    ViewChange change;
    std::shared_ptr<const RestIndex> index;
    SharedArray<uint8_t> on_skin;
  };
  Drawn draw_surface();
  void make_surface(Version& next, Drawn drawn);  // with its embedding in next.lattice
  std::optional<SurfacePoint> find_skin(const ChartPoint& p, std::string& reason) const;
  std::optional<Anchor> find_anchor(const ChartPoint& p, bool on_rim, std::string& reason) const;
  /// Of a stitch's bite: on the rim near p, or so deep in the wall below it.
  std::optional<Anchor> find_bite(const ChartPoint& p, double depth_mm, std::string& reason) const;
  std::optional<Anchor> bite_at(const SurfacePoint& rim, double depth_mm, std::string& reason) const;
  /// Index into stitches_.
  std::optional<size_t> find_stitch(const StitchPick& pick, std::string& reason) const;
  const RimWalk& rim() const;
  void widen(Anchor& bite) const;
  Vec3 held_mm(const Anchor& bite) const;                                  // where it is held now
  Stitch between(const Anchor& a, const Anchor& b, double bite_mm) const;  // without numbers, open as it lies
  Outcome sew_row(const std::vector<std::pair<Anchor, Anchor>>& bites, const RowKind& kind, bool whole);
  /// One thread through these spans in their order.
  void thread_through(std::vector<Stitch> spans, bool corner, double slack_mm);
  void draw(Thread& thread) const;
  void drop_thread(int32_t thread);  // and its spans
  void draw_tight();
  void note_forces(const StepReport& report);
  EmbeddedPoint embed(const Anchor& anchor) const;
  bool carry_anchors();  // true when something was lost with its tissue
  bool same_place(const Anchor& a, const Anchor& b) const;
  bool joins(const Stitch& stitch, const Anchor& a, const Anchor& b) const;  // the same two places, either way round
  std::vector<Spring> springs() const;  // of hooks and stitches, as the solver gets them
  void publish_springs();
  StepReport solve(const StepSettings& settings);
  ContactMemory contact_memory() const;
  bool follow_contacts();  // true when the solver has others now; nothing is done where nothing has been cut
  BladeContext blade_context() const;
  Moment moment() const;
  /// `parent`: per node of its model, the node of the present one (-1: none); empty when the model stays.
  void return_to(const Moment& m, ParentList parent);
  void remember(Done done);  // a new act: what was undone before it cannot be redone any more
  Vec3 position_mm(const EmbeddedPoint& e) const { return solver_->position_mm(e); }

  WorldSpec spec_;
  std::shared_ptr<const Body> body_;
  std::shared_ptr<const Skin> shared_skin_;  // pictures may outlive the table
  const Skin& skin_;
  std::unique_ptr<Arrangement> arrangement_;  // absent when the scene cannot be cut
  std::unique_ptr<StencilTable> stencils_;
  Version version_;
  std::unique_ptr<ElasticSolver> solver_;
  Workers& workers_;
  std::unique_ptr<ContactFinder> contacts_;                  // absent as long as there is no wall
  uint64_t contacts_version_ = 0;                            // of the surface that it was made for
  std::shared_ptr<const LatticeTopology> contacts_lattice_;  // that the finder is for
  std::optional<ContactMemory> contacts_to_resume_;  // brought back by undo or redo, for the next step to take up
  ContactCounts contact_counts_;                     // of finders that are gone
  std::vector<Hook> hooks_;
  std::vector<Stitch> stitches_;  // threads' spans together, in their order
  std::vector<Thread> threads_;
  mutable std::unique_ptr<RimWalk> rim_;  // of the surface rim_version_; absent until a stitch needs it
  mutable uint64_t rim_version_ = 0;
  // Energy of the open wound: of the last state at rest in which neither hook nor stitch held anything.
  std::optional<double> open_energy_uJ_;
  double energy_uJ_ = 0;
  // During an act: the lattice after a part of its cuts, its parents in version_.lattice. Null: nothing was followed
  // yet.
  std::shared_ptr<const LatticeTopology> followed_;
  uint64_t followed_hash_ = 0;      // of the arrangement then
  Divide divide_ = Divide::fronts;  // of the lattice's cells by the act at hand
  std::vector<Done> done_;
  std::vector<Undone> undone_;
  std::optional<Stroke> stroke_;
  int stopped_stroke_ = 0;  // one whose rest is refused, and why
  std::string why_stopped_;
  PointDepths depths_;
  mutable std::unique_ptr<TensionField> tension_;
  std::unique_ptr<PressProbe> press_;  // absent until something presses
  mutable uint64_t tension_version_ = 0;
  double initial_volume_mm3_ = 0, volume_mm3_ = 0, removed_volume_mm3_ = 0;
  uint64_t steps_ = 0, cuts_ = 0;
  uint64_t next_version_ = 1;
  mutable uint64_t hash_ = 0, hash_version_ = 0;  // topology_hash() of that version
  int32_t next_spring_ = 1, next_stitch_ = 1, next_thread_ = 1, stage_ = -1;
  int refused_ = 0;
  float residual_ = 0, distance_mm_ = 0;
};

}  // namespace limberg
