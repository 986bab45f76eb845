#pragma once
// What a patient came to, looked at as a teacher looks: everything that can be wrong with it, worst first, each with
// its value, its limit, where that limit comes from, and the place. Every command that ends with a patient has one:
// result.json carries it (`verdict`), the report begins with it and a terminal ends with it. Where a line is bad the
// work has not reached its goal: `ok` is false and the exit status 3.
//
// A wound is meant to be closed once there is a stitch in it at the end, or a lesson asks for its gape. Then all of its
// edge counts: between stitches, at the ends, stretches that were not sewn. A wound without a stitch is told as open
// and is no fault: an operation that was never said to close. A lesson's tolerance wins over the limits here.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/assembly/lesson.h"
#include "app/result/schema.h"
#include "sim/body/body.h"
#include "sim/measure/bone_outside.h"
#include "sim/measure/metrics.h"

namespace limberg {

/// How the session's clock was slowed down for the patient.
struct SlowedPace {
  double session_s = 0, added_s = 0;  // how long it took by its own clock, how much longer by the wall's
  double slowest = 1;                 // of the wall's pace, over the slowest second
};

/// How the patient kept up with the hand. Times of the snapshot that the hand had, over all device ticks.
struct Pace {
  int64_t steps = 0, skipped = 0;  // of the solver
  double behind_p99_ms = 0, behind_max_ms = 0;
  std::optional<SlowedPace> slowed = {};  // nothing: it kept real time
};

struct VerdictOf {
  const Metrics* metrics = nullptr;  // null: no soft tissue
  const Body* body = nullptr;        // its chart and its skin; with metrics
  double cell_mm = 0;                // of its lattice
  int wound_level = 0;               // how often its cells are divided where a blade went
  std::span<const Judgement> judged = {};
  std::optional<BoneOutside> bone = {};  // nothing: no face over bones
  std::optional<Pace> pace = {};         // nothing: there was no hand
  double residual = 0;                   // relative, at the end
  bool stalled = false;                  // more iterations gain nothing
  bool cut_short = false;                // somebody ended it before it came to rest: said, and no fault
};

/// Bad ones first, then what is worth a look, then what is told and what is good.
std::vector<ResultVerdict> verdict_of(const VerdictOf& of);
/// The order in which lines stand in a verdict; those of the same kind stay as they are.
void worst_first(std::vector<ResultVerdict>& verdict);
bool is_bad(std::span<const ResultVerdict> verdict);
/// On the terminal: bad lines and those worth a look, and what is good of a wound; nothing where there is nothing.
void print_verdict(std::span<const ResultVerdict> verdict);

}  // namespace limberg
