#pragma once
// What a session came to, in the words of result.json (run, replay, emulate).
#include <string>

#include "app/assembly.h"
#include "app/result.h"
#include "devices/lcm_log.h"

namespace limberg {

/// Everything but `damage`: mode, duration, hashes, parts, memory, the three lanes, latencies, stages, series, refusals,
/// force balance and metrics.
void fill_session(Result& result, Assembly& session, const SessionFigures& figures, bool real_time);

/// The counts of a damaged recording under `damage`; nothing when there is none.
void fill_damage(Result& result, const LogDamage& damage);


}  // namespace limberg
