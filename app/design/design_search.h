#pragma once
// Which flap for this defect? Candidates from the repertoire,
// each as small as covers the defect, carried out and ranked.
//
//   1. every type of design in several orientations (and mirrored),
//      sized so that its excision just holds the defect's outline;
//   2. those that leave the skin, cut a landmark's place away or pass within 2 mm of one are dropped;
//   3. all others are carried out on coarse cells, without
//      contact between wound surfaces (it costs several times
//      as much and hardly changes which design pulls more)
//      and with stitches no nearer than cells are large, the
//      best few again on fine ones as the scene is.
//
// Costs of the two passes are no measure of each other: coarse cells and edges that
// lie in each other change both forces and heights. So the refined ones are ranked
// among themselves, and come first; the others follow, ranked by the first pass.
//
// Cost = force / 2.45 N + dog-ear / 4 mm + landmark / 2 mm: the largest force of a stitch at rest
// over the closing tension above which necrosis rose (Larrabee, Holloway and Sutton 1984), the
// highest skin over what may be left to settle (4 mm), the largest displacement of a landmark
// over what counts as acceptable in predicting soft tissue. Each over its own limit; that they
// are added, and with which weights, is a choice: no source says how a surgeon weighs them.
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/scene/scene.h"
#include "sim/commands/procedures/operation.h"
#include "sim/measure/metrics.h"

namespace limberg {

class Workers;

struct DesignTask {
  std::vector<ChartPoint> defect;  // outline on the chart
  std::vector<Landmark> spare;
  std::vector<std::string> types;     // names of procedures; empty: all that can cover a defect
  double turn_step_deg = 60;          // between orientations of one type
  double coarse_mm = 5, fine_mm = 0;  // cells; fine 0: the scene's
  int refine = 3;                     // how many of the best are carried out again
  double weight_force = 1, weight_ear = 1, weight_landmark = 1;
  OperationPlan plan;
};

struct Design {
  PlannedProcedure plan;
  Figure figure;
  std::vector<Command> commands;
  std::string dropped;  // why it was not carried out; empty: it was
  bool fine = false;    // what follows is of the second pass
  double cell_mm = 0, residual = 0;
  double force_N = 0, closure_N = 0, dog_ear_mm = 0, landmark_mm = 0, waste_mm2 = 0, scar_mm = 0;
  double force_cost = 0, ear_cost = 0, landmark_cost = 0, cost = 0;  // with their weights; the sum
  double first_cost = 0;                                             // that sum in the first pass
  std::string name() const;                                          // "rhomboid 18.5 mm at 60 degrees"
};

/// The outline of "circle:X,Y,D" (diameter) or "X,Y;X,Y;X,Y;...". InputError otherwise.
std::vector<ChartPoint> parse_defect(const std::string& text);

/// In words: what the cost of a design is made of, and by which part
/// most the next one (of the same pass; may be null) costs more.
std::string why_first(const Design& first, const Design* next);
/// The dropped ones by reason, most frequent first: how many of each.
std::vector<std::pair<std::string, int>> dropped_by_reason(std::span<const Design> all);

/// Types that can cover a defect.
const std::vector<std::string>& covering_types();

/// Candidates before any of them is carried out; dropped ones with their reason.
std::vector<Design> candidates(const Scene& scene, const Skin& skin, const DesignTask& task);

/// Carries one out and fills its figures and cost; `dropped` when the patient refuses an action.
void carry_out(Design& design, const Scene& scene, const std::shared_ptr<const Body>& body, const DesignTask& task,
               double cell_mm, bool fine, Workers& workers, const std::function<bool()>& interrupted);

/// How far a search has come. `share` of the work: 0 to 1, a fine design counted as what it takes against a coarse one.
struct SearchProgress {
  int done = 0, total = 0;  // designs
  bool fine = false;
  double share = 0;
};

/// Refined ones by their cost, then those of the first pass by theirs, then the dropped by name.
void rank(std::vector<Design>& designs);

/// All of it, ranked.
std::vector<Design> search_designs(const Scene& scene, const DesignTask& task, Workers& workers,
                                   const std::function<bool()>& interrupted,
                                   const std::function<void(const SearchProgress&)>& progress);

}  // namespace limberg
