#pragma once
// Commands of the program on a tiny patient, and seeded faults to do to them.
#include <cstdint>
#include <string>
#include <vector>

#include "tests/bench/faults/journal.h"

namespace limberg::bench::faults {

/// A call of the program: its words, and what it leaves. @ stands for the case's own folder, % for that of what all
/// calls read.
struct Call {
  const char* name;
  std::vector<std::string> words;
  std::string recording, result;  // in the case's folder; empty: none
  std::string reads;              // a recording in the common folder that must not change; empty: none
  const char *begins, *starts;    // the files whose opening is the beginning of its work, and of all
  bool live;                      // against the clock
  enum Device { none, fastrak, lcm } device = none;  // that whoever starts it serves
};
const std::vector<Call>& calls();

struct KindName {
  Kind kind;
  const char* name;
  const char* meaning;
};
/// Those of a machine, not the planted ones.
const std::vector<KindName>& kinds();
const char* name_of(Kind kind);

struct Case {
  int64_t number = 0;
  size_t call = 0;  // in calls()
  Kind kind = Kind::none;
  int64_t at = 0, more = 0;
  int thread = 0;
  bool early = false;  // counted from its start, not from the beginning of its work
  std::string fault() const;
};

/// How often a call does what can fail, without any fault.
struct Counts {
  int64_t readings = 0, writes = 0, opens = 0, renames = 0, syncs = 0, threads = 0;
  std::vector<int64_t> allocations;
};
Counts counts_of(const Journal& journal);

/// The number-th case of a seed. `counts` by call, twice: from the beginning of its work, from its start.
Case case_of(uint64_t seed, int64_t number, const std::vector<Counts> (&counts)[2]);

/// Writes scene and script into a folder.
void write_patient(const std::string& folder);

}  // namespace limberg::bench::faults
