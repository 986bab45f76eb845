#pragma once
// A benchmark suite as limberg_bench lists it: its name, what it measures, and how it is run with the command's
// options.
//
// A suite is added by its own files and an entry in suites.cpp.
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/operating_point/bench.h"
#include "app/report/svg_chart.h"
#include "app/result/result.h"

namespace limberg::bench {

struct SuiteOptions {
  std::string scene, only, out_dir;  // out_dir: empty, or a folder that can be written
  bool quick = false, no_peers = false;
  // fuzz
  bool world = false, devices = false, readers = false;
  int front_levels = 0, check_every = 1, divide_every = 1;
  int64_t operations = 0;  // 0: the suite's own number
  uint64_t seed = 1;
  // accuracy
  double budget_ms = 0, limit_s = 150;
  double minutes = 0;  // soak; 0: the suite's own number
  std::function<void(const std::string&)> progress;
};

struct SuiteOutcome {
  Result result;
  std::string scene;  // that it was measured on; empty: scenes of its own
  std::vector<std::pair<std::string, LineChart>> charts;
  std::function<void(limberg::Result&)> also;  // what else stands in result.json; may be empty
  std::string interrupted;                     // what is said when the user stopped it; empty: it ran to its end
};

struct Suite {
  const char* name;
  const char* measures;  // what it is for, in a line
  const char* parts;     // what --only can name; empty: it has no parts
  bool takes_scene;
  SuiteOutcome (*run)(const SuiteOptions& options);
};

/// All suites by name.
std::span<const Suite> suites();

}  // namespace limberg::bench
