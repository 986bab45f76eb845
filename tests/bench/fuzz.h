#pragma once
// `limberg bench fuzz`: random operations on small bodies, every invariant after each of them (fuzz/runner.h).
//
// Histories of up to 24 operations, alternately in general position and adversarial (fuzz/generator.h). A violated
// invariant is made small (operations and blade triangles are left out while it still shows) and written to a file.
#include <functional>
#include <string>

#include "app/operating_point/bench.h"
#include "tests/bench/fuzz/runner.h"

namespace limberg::bench {

struct FuzzSettings {
  int64_t operations = 10000;
  uint64_t seed = 1;
  uint64_t first_history = 0;  // to begin in the middle of a longer run
  int check_every = 1;         // operations between full checks
  int max_violations = 20;     // then it stops
  int shrink_runs = 400;       // given to making one small
  std::string
      out_dir;  // for repro files, of violations and of refused cuts in general position; empty: none are written
  std::function<void(const std::string&)> progress;  // empty: silent
  std::function<bool()> stop;  // asked between histories: true ends the run, what was done is reported
  bool generic = true, adversarial = true;
  int front_levels = 0;  // of the lattice: how often cells at a front are divided
  int divide_every = 1;  // ... in one of so many histories of either kind
  fuzz::Settings runner;
};

struct FuzzReport {
  fuzz::Counts generic, adversarial;
  uint64_t seed = 0;
  struct Violation {
    std::string what, file;
    fuzz::Case small;
  };
  std::vector<Violation> violations;
  struct Refusal {  // of a cut in general position after all its tries
    uint64_t history = 0;
    int32_t op = 0;
    std::string name, reason, file;
  };
  std::vector<Refusal> refusals;
  double cpu_s = 0;
  int64_t divided = 0;  // operations on lattices whose fronts are divided

  int64_t operations() const { return generic.operations + adversarial.operations; }
  Result result() const;  // rows and bars
};

FuzzReport fuzz_run(const FuzzSettings& settings);

/// Leaves out operations and triangles while the case still breaks an invariant, in at most `runs` runs.
fuzz::Case make_small(fuzz::Case c, const fuzz::Settings& settings, int runs);

}  // namespace limberg::bench
