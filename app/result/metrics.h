#pragma once
// Measurements of a patient on their way into result.json.
#include <span>

#include "app/result/schema.h"
#include "sim/measure/metrics.h"
#include "sim/patient/world.h"

namespace limberg {

/// All figures of a patient; `script`: what was done to it.
Metrics measure_world(const World& world, std::span<const Command> script, MeasureAlso also = {});

inline ResultVector vector_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// `metrics` and `balance`.
void fill_metrics(Result& result, const Metrics& metrics);

}  // namespace limberg
