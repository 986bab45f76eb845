#pragma once
// A made-up snapshot for tests: a wavy slab of skin with a wedge cut out of its middle, walls included, and stitches.
#include <memory>

#include "sim/patient/snapshot.h"

namespace limberg::testing {

struct SampleOptions {
  int cells = 60;  // per side of the 60 mm slab
  bool wound = true;
  double wave_mm = 0.8;
  int sutures = 5;
  int hooks = 1;
};

Snapshot sample_snapshot(const SampleOptions& options = {});

}  // namespace limberg::testing
