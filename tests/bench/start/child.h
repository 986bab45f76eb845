#pragma once
// A child whose peak memory, times and libraries are asked for.
#include <string>
#include <vector>

namespace limberg::bench {

struct ChildFigures {
  int status = -1;           // exit status; -1: it was killed, or could not be started
  double peak_mb = 0;        // resident
  double until_line_s = -1;  // from its start until it first wrote a line to standard error; -1: it wrote none
  double took_s = 0;
  std::vector<std::string> libraries;  // file names of what the process has loaded, at its start or later
};

/// Runs words[0]; what it prints goes nowhere. `folder`: for what the loader has to say.
ChildFigures run_child(const std::vector<std::string>& words, const std::string& folder);

}  // namespace limberg::bench
