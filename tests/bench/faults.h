#pragma once
// limberg bench faults: seeded faults over run, run --continue, emulate, replay and operate (faults/harness.h).
#include <cstdint>
#include <functional>
#include <string>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct FaultsSettings {
  int64_t cases = 2000;
  uint64_t seed = 1;
  std::function<void(const std::string&)> progress;
  std::function<bool()> stop;
};

/// A row for each kind of fault and each call; bars: none hangs, crashes, is speechless, loses more than a second, or
/// says that it succeeded when it did not.
Result faults_suite(const FaultsSettings& settings);

}  // namespace limberg::bench
