#pragma once
// Measurements of a patient on their way into result.json.
#include "app/result/schema.h"
#include "sim/measure/metrics.h"
#include "sim/measure/patient.h"

namespace limberg {

inline ResultVector vector_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// `metrics` and `balance`.
void fill_metrics(Result& result, const Metrics& metrics);

}  // namespace limberg
