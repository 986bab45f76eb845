#pragma once
// `limberg bench fuzz --devices`: what comes over a serial line, a network or out of a file, damaged
// in every way, against what the program takes for whole. Three families, a third of the cases each:
//
//   line     records of a FASTRAK with bytes lost, changed, put in,
//            cut off or replaced by noise; and the conversation
//            with the device fed with such bytes at odd times
//   packet   LCM messages with changed bits, bytes and lengths
//   log      recordings with the same, and with whole stretches missing, doubled or cut
//
// A case is one damaged record, packet or event. No case may crash or hang; bytes may not be lost count of; what
// is taken must be finite and in range; and what is taken but was never sent is counted against the share that
// the checks let through by design: fastrak::accepted_share for the line, 2^-32 for what carries a checksum.
#include <cstdint>
#include <functional>
#include <string>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct DevicesFuzzSettings {
  int64_t cases = 1'200'000;
  uint64_t seed = 1;
  std::function<void(const std::string&)> progress;  // empty: silent
};

struct DevicesFuzzReport {
  struct Family {
    int64_t cases = 0;
    int64_t taken = 0;          // whole again or not hit where it matters
    int64_t wrong = 0;          // taken with other content than any that was sent
    int64_t far = 0;            // line: of those, more than 3 mm or 3 degrees off
    int64_t violations = 0;     // out of range, not finite, miscounted, out of order
    double expected_wrong = 0;  // share of the cases
    double cpu_ms = 0;
  };
  Family line, replaced, noise, talk, packet, log;  // replaced: lines with exactly one byte replaced
  double expected_far = 0;
  uint64_t seed = 0;
  std::string first_violation;
  int64_t cases() const { return line.cases + replaced.cases + noise.cases + talk.cases + packet.cases + log.cases; }
  int64_t violations() const {
    return line.violations + replaced.violations + noise.violations + talk.violations + packet.violations +
           log.violations;
  }
  Result result() const;
};

DevicesFuzzReport devices_fuzz(const DevicesFuzzSettings& settings);

}  // namespace limberg::bench
