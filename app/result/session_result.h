#pragma once
// What a session came to, in the words of result.json (run, replay, emulate), and parts of it that scripts leave too
// (operate).
#include <span>
#include <string>

#include "app/assembly/assembly.h"
#include "app/assembly/lesson.h"
#include "app/assembly/verdict.h"
#include "app/result/run_result.h"
#include "devices/lcm_log.h"

namespace limberg {

/// Everything but `damage`: mode, duration, hashes, parts, memory, the three lanes, latencies, stages, series,
/// refusals, force balance, metrics and the exercise's figures.
/// With a lesson: its tolerances, and its plan instead of the one that the cuts show.
/// Returns the verdict, which the result has too. `printed`: what the lesson asked goes to standard output.
std::vector<ResultVerdict> fill_session(Result& result, Assembly& session, const SessionFigures& figures,
                                        bool real_time, const Lesson* lesson = nullptr, bool printed = true);

/// `verdict`.
void fill_verdict(Result& result, std::span<const ResultVerdict> verdict);

/// Name, picture and residual.
ResultStage stage_of(const StageRow& stage);
ResultSeries series_of(const SolverSeries& series);
/// A line for each act; nothing where nothing was done.
MaybeList<std::string> script_of(std::span<const Command> done);

/// The counts of a damaged recording under `damage`; nothing when there is none.
void fill_damage(Result& result, const LogDamage& damage);

}  // namespace limberg
