#pragma once
// Measurements of a patient on their way into result.json.
#include "app/result.h"
#include "sim/world.h"

namespace limberg {

/// `metrics` and `balance`.
void fill_metrics(Result& result, const World& world);

/// The three figures that a change of resolution is judged by.
struct KeyMetrics {
  double closure_force_N = 0, suture_gap_max_mm = 0, dog_ear_mm = 0;
};
KeyMetrics key_metrics(const World& world);

}  // namespace limberg
