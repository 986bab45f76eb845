#pragma once
// `limberg bench start`: what the program takes before and while it works, nothing drawn and drawn: peak memory of a
// child, time from its start until its session's clock runs (the patient is made then, its first solver step due), and
// the libraries that it has mapped by its end. The child is `limberg`, which stands beside the bench.
#include "tests/bench/suite.h"

namespace limberg::bench {

struct StartSettings {
  bool quick = false;  // the tiny scene and the rhomboid only
  std::string only;    // scenes whose name contains this
  std::function<void(const std::string&)> progress;
};

SuiteOutcome start(const StartSettings& settings);

}  // namespace limberg::bench
