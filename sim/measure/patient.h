#pragma once
// The figures of a patient as it is: metrics.h with everything that it asks for taken from there.
#include <span>

#include "sim/commands/command.h"
#include "sim/measure/metrics.h"
#include "sim/patient/world.h"

namespace limberg {

/// All figures of a patient with skin (world.skin() must be there); `script`: what was done to it.
Metrics measure_world(const World& world, std::span<const Command> script, MeasureAlso also = {});

}  // namespace limberg
