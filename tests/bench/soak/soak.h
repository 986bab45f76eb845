#pragma once
// `limberg bench soak`: many emulated operations in one process, by the program's own commands, one after the other:
//
//   lockstep   emulate SCENE SCRIPT --seed S            at full speed
//   live       run SCENE --device log:STREAM --record   at the hand's own pace, then `replay` of what was recorded
//   acts       10,000 random acts with undo and redo on one patient, then all of it taken back
//
// Scenes and seeds return in a cycle: the second time the same hash is expected. After each round the process is looked
// at (process_state.h). What a round needs is given back; what grows from round to round is a leak.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/bench/soak/process_state.h"
#include "tests/bench/suite.h"

namespace limberg::bench {

struct SoakSettings {
  double minutes = 120;  // of lockstep and live together; a third of them live
  int64_t acts = 10'000;
  std::string only, out_dir;  // out_dir: empty, or where the curves go
  std::function<void(const std::string&)> progress;
  std::function<bool()> stop;
};

/// One operation.
struct SoakRound {
  std::string part, scene;  // part: "lockstep", "live"
  uint64_t seed = 1;        // of the hand
  double at_min = 0;        // when it had ended
  std::string hash;         // of the patient at its end; live: of the replay, where that is not as it was recorded
  bool as_expected = true;  // exit status 0, and live: the replay met every checkpoint
  double median_ms = 0, p95_ms = 0, cpu_ms = 0;  // of a solver step; cpu: of the whole process
  ProcessState after;
};

constexpr double kSettledMin = 10;  // for so long what a process keeps may still grow

/// Rows and bars of these rounds: memory flat, files and threads given back, times and hashes as they were at first.
Result judge_soak(const std::vector<SoakRound>& rounds);
std::string soak_csv(const std::vector<SoakRound>& rounds);

SuiteOutcome soak(const SoakSettings& settings);

}  // namespace limberg::bench
