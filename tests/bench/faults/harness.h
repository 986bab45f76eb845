#pragma once
// Does seeded faults to child processes, the real program on a tiny patient, and judges what each left.
//
//   hang       it had not ended after kLongest_s
//   crash      a signal that was not the fault ended it, or it spoke of a defect of its own
//   speechless it ended with another status than 0 and did not say why
//   lost       its recording lacks more than the last second before the fault, or is no recording, or does not replay
//              to the bits that it holds, or the recording that it read was touched
//   wrong      it ended with status 0, and what it left is not what it leaves without a fault
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/bench/faults/cases.h"

namespace limberg::bench::faults {

constexpr double kLongest_s = 40;

struct Judgement {
  Case of;
  int status = 0;        // exit status; 1000 + signal
  bool reached = false;  // the fault was met
  bool hang = false, crash = false, speechless = false, lost = false, wrong = false;
  std::string why;   // in a line; empty: nothing is wrong
  std::string said;  // the end of what it said
  bool sound() const { return !hang && !crash && !speechless && !lost && !wrong; }
};

struct Settings {
  int64_t cases = 2000;
  uint64_t seed = 1;
  int at_once = 6;
  std::vector<Case> only;  // these instead of seeded ones; `at` < 0: percent of what the call does without a fault
  std::function<void(const std::string&)> progress;
  std::function<bool()> stop;
};

/// InputError: program or shim are not where the build leaves them, or a call fails without any fault.
std::vector<Judgement> run_cases(const Settings& settings);

}  // namespace limberg::bench::faults
