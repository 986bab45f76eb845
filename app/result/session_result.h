#pragma once
// What a session came to, in the words of result.json (run, replay, emulate).
#include <string>

#include "app/assembly/assembly.h"
#include "app/assembly/lesson.h"
#include "app/result/result.h"
#include "devices/lcm_log.h"

namespace limberg {

/// Everything but `damage`: mode, duration, hashes, parts, memory, the three lanes, latencies, stages, series,
/// refusals, force balance, metrics and the exercise's figures.
/// With a lesson: its tolerances, and its plan instead of the one that the cuts show.
void fill_session(Result& result, Assembly& session, const SessionFigures& figures, bool real_time,
                  const Lesson* lesson = nullptr);

/// The counts of a damaged recording under `damage`; nothing when there is none.
void fill_damage(Result& result, const LogDamage& damage);

}  // namespace limberg
