#pragma once
// The part of `limberg bench devices` that draws which stiffness a force device holds (z_width.h).
#include <functional>
#include <string>

#include "tests/bench/suite.h"

namespace limberg::bench {

/// Rows by delay, damping and faults; bars; the chart of stiffness against damping, with the bounds of the literature.
void add_z_width(SuiteOutcome& out, bool quick, const std::function<void(const std::string&)>& progress);

}  // namespace limberg::bench
