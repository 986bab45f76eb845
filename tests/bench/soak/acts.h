#pragma once
// A long session on one patient: random acts (fuzz/world_generator.h) with undo and redo, a thousand at a time; then
// all that can be taken back is. What the history holds goes with it: memory is the same after every thousand, and so
// is the patient, to the last bit.
#include "tests/bench/soak/soak.h"

namespace limberg::bench {

Result soak_acts(const SoakSettings& settings);

}  // namespace limberg::bench
