#pragma once
// What stands on the patient, set against the plan: which planned acts are done, by whom and how well, which is next,
// and what belongs to no plan.
//
// Each act that stands is the attempt at the planned act that it fits best. Hooks are means: their planned acts count
// as passed over once a later cut or stitch of the plan is done. A row of stitches may be sewn stitch by stitch, a line
// cut in several strokes, a bone sawn through by several lines.
#include <cstdint>
#include <optional>
#include <vector>

#include "app/teaching/against_plan.h"
#include "sim/commands/authorship.h"

namespace limberg {

struct ActProgress {
  enum State : uint8_t { open, done, passed } state = open;
  bool shown = false;            // by the program
  size_t by = 0;                 // done: the act that stands, of a cut in several strokes the last
  Offs offs;                     // done: what was looked at
  std::vector<size_t> before;    // of a cut in several strokes: the others
  std::optional<Incise> joined;  // and all of it
};

/// A line that a hand sawed along a part of a planned cut.
struct SawnPart {
  size_t standing = 0, act = 0;
  Offs offs;
  double share = 0;  // of the planned line that is sawn with it and the ones before it
};

struct PlanProgress {
  std::vector<ActProgress> act;  // one for each planned
  std::vector<SawnPart> part;    // of cuts that are open still
  std::vector<size_t> stray;     // acts that stand and are no attempt at anything planned
  size_t next = 0;               // the first that is open; their number: all is done

  bool all_done() const { return next == act.size(); }
  std::vector<size_t> open() const;
};
PlanProgress progress_of(const LessonPlan& plan, const std::vector<StandingAct>& standing);

/// What was drawn for a planned act that is done, as one line; nothing: it is not drawn.
std::optional<DrawnLine> drawn_for(const ActProgress& act, const std::vector<StandingAct>& standing);
/// The planned act that this one is an attempt at; -1: none.
int attempt_at(const PlanProgress& progress, size_t standing);

/// How many entries of the history must be taken back until only what follows the plan stands: nothing stray, and
/// nothing own that is off by more than twice its limit.
int undos_to_plan(const LessonPlan& plan, const std::vector<StandingAct>& standing);
/// What stands after so many undos.
std::vector<StandingAct> after_undos(std::vector<StandingAct> standing, int undos);

/// The planned act as it is to be done here: hooks by the numbers that they have on this patient; places turned and
/// shifted with the learner's cuts, where these lie elsewhere than the plan's.
Command adapted(const LessonPlan& plan, size_t act, const PlanProgress& progress,
                const std::vector<StandingAct>& standing);

}  // namespace limberg
