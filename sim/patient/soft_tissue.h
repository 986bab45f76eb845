#pragma once
// The soft tissue of a patient under the knife: cuts, hooks, sutures, solver steps.
//
// An act is atomic. A cut goes blade -> arrangement -> lattice -> finite elements -> surface in one transaction
// (tissue_cut.h); whatever refuses on the way, or throws, all before it is taken back. What cannot be cut is refused;
// what memory does not suffice for, and a defect of the program, is thrown on.
//
// An act that can be undone gives a Change to the patient's history (world.h): the moment before it, and the operations
// of the arrangement, which takes these back and makes them again from the same blade, seed and try: the same bits,
// which is checked. An incision may come in pieces while it is drawn (cutting/strokes/drawn_stroke.h); they are cut one
// by one, and are one change.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/commands/acted.h"
#include "sim/patient/contact_driver.h"
#include "sim/patient/hooks.h"
#include "sim/patient/press_probe.h"
#include "sim/patient/publisher.h"
#include "sim/patient/skin_loads.h"
#include "sim/patient/soft_hold.h"
#include "sim/patient/sutures.h"
#include "sim/patient/tissue_cut.h"

namespace limberg {

struct OpenStroke;  // open_stroke.h

/// What takes an act on soft tissue back, and makes it again.
struct TissueChange {
  TissueMoment before;
  std::optional<TissueMoment> after;  // as it was when it was taken back
  std::vector<CutStep> steps;
  ParentList ancestor;  // per node after it: the node before; empty when the lattice is the same

  /// `later` is of the same stroke. If memory does not suffice, both are as before.
  void append(TissueChange& later);
};

class SoftTissue {
 public:
  SoftTissue(WorldSpec spec, Workers& workers);
  ~SoftTissue();
  SoftTissue(const SoftTissue&) = delete;  // its parts know each other
  SoftTissue& operator=(const SoftTissue&) = delete;

  Acted<TissueChange> act(const Command& command);
  /// Whether the pen or the swab can pass there; nothing of the tissue changes. Refused: a place in space is off the
  /// skin.
  Outcome draw_on(const Command& command) const;
  void take_back(TissueChange& change);
  Outcome make_again(TissueChange& change);
  /// Another part of the patient has acted: a stroke that has cut cannot go on.
  void another_act() noexcept;
  /// The history goes back or forth: no stroke can go on.
  void stop_stroke(std::string_view why) noexcept;

  StepReport step(const StepSettings& settings);
  /// Takes what holds the tissue elsewhere: every held node to where(its place at rest), in mm. Free nodes stay where
  /// they are until the next step. Cuts keep it; undo goes back to how the tissue was held then.
  void hold_at(const std::function<Vec3(const Vec3& X_mm)>& where) { tissue_.hold_at(where); }
  /// Reuses the snapshot's memory. The tension field costs a few ms and is filled only when asked for.
  void fill(Snapshot& snapshot, bool with_field = false) const;
  /// How stiff the tissue is against a tool that presses here (press_probe.h). Asking changes no bit of it.
  PressAnswer press(const PressQuestion& question, int iterations = 8);

  std::shared_ptr<const SurfaceTopology> topology() const { return tissue_.version().surface; }
  uint64_t topology_hash() const { return tissue_.topology_hash(); }  // same on every machine
  uint64_t state_hash() const;                                        // positions, topology, hooks and sutures
  /// Over all that undo and redo bring back. For tests; O(everything).
  uint64_t full_hash() const;
  bool settled() const { return sutures_.settled(); }  // every stitch is drawn tight

  // For measurement (sim/measure).
  const WorldSpec& spec() const { return tissue_.spec(); }
  /// Of the body as it came, at rest.
  const Skin& skin_at_rest() const { return tissue_.skin(); }
  const ElasticSolver& solver() const { return tissue_.solver(); }
  const Arrangement* arrangement() const { return tissue_.arrangement(); }  // null when the scene cannot be cut
  std::shared_ptr<const LatticeTopology> lattice() const { return tissue_.version().lattice; }
  double volume_mm3() const { return figures_.volume_mm3; }                  // exact, of all remaining pieces at rest
  double removed_volume_mm3() const { return figures_.removed_volume_mm3; }  // exact, of what was excised
  double initial_volume_mm3() const { return tissue_.initial_volume_mm3(); }
  int pieces() const { return tissue_.version().lattice->pieces; }  // connected pieces of the lattice
  std::vector<int> stitches_in_one_bank() const { return sutures_.in_one_bank(); }
  ContactCounts contact_counts() const { return contacts_.counts(); }       // what contact has cost so far, counted
  Vec3 collider_force_mN() const { return contacts_.collider_force_mN(); }  // sum, on the tissue
  Vec3 soft_hold_force_mN() const { return soft_hold_.force_mN(); }         // the same, of springs that hold it softly
  /// Elastic energy, threads included (and weight and loads by what they have done), above that of the open wound: of
  /// the last state at rest (residual 1e-3) that neither hook nor stitch held. Nothing as long as there was none, or a
  /// hook still pulls. Cutting after it goes into the difference.
  std::optional<double> closure_energy_uJ() const;

 private:
  Acted<TissueChange> carry_out_act(const Command& command);
  Acted<TissueChange> cut(const Incise&);
  Acted<TissueChange> cut(const InciseMore&);
  Acted<TissueChange> cut(const Undermine&);
  Acted<TissueChange> cut(const Excise&);
  Acted<TissueChange> cut(const ExcisePiece&);
  Acted<TissueChange> cut(const CutThrough&);
  Acted<TissueChange> activate(const Activate&);
  /// The same act where its places lie (act_in_space.cpp).
  Acted<TissueChange> act_in_space(const InSpace&);
  /// What of the stroke that is being drawn can be cut by now; refused: nothing has changed.
  Acted<TissueChange> cut_on(bool last);
  CutResult cut_stroke(TissueCut& cut, const std::vector<ChartPoint>& path, double depth_mm, double angle_deg,
                       bool spline);
  /// What follows the cuts of one act: lattice, model and surface anew, anchors carried.
  Acted<TissueChange> finish(TissueCut& cut);
  uint64_t seed() const;  // of the next cut
  /// What holds and loads the tissue, to the solver.
  void publish_holding();
  std::vector<Spring> all_springs();
  TissueMoment moment() const;
  /// `parent`: per node of its model, the node of the present one (-1: none); empty when the model stays.
  void return_to(const TissueMoment& m, ParentList parent);

  Tissue tissue_;
  Holding holding_;
  TissueFigures figures_;
  Hooks hooks_{tissue_, holding_};
  Sutures sutures_{tissue_, holding_};
  SkinLoads loads_{tissue_, holding_};
  SoftHold soft_hold_{tissue_};
  ContactDriver contacts_{tissue_};
  mutable Publisher publisher_;
  std::unique_ptr<PressProbe> press_;   // absent until something presses
  std::unique_ptr<OpenStroke> stroke_;  // absent: nothing is being drawn
  int stopped_stroke_ = 0;              // one whose rest is refused, and why
  std::string why_stopped_;
};

}  // namespace limberg
