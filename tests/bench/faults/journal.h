#pragma once
// What a process under the shim (shim.cpp) did until now: in a file that it maps, so that it is there whatever ends the
// process. Counts begin when the file that arms the shim is opened.
#include <atomic>
#include <cstdint>

namespace limberg::bench::faults {

struct Journal {
  static constexpr int kThreads = 16;  // in the order in which they were started; later ones count as the last
  std::atomic<int64_t> armed;
  std::atomic<int64_t> injected;       // how often the fault was put in
  std::atomic<int64_t> readings;       // of a clock
  std::atomic<int64_t> readings_then;  // when the fault was first put in
  std::atomic<int64_t> wakes_then;     // the same of the busiest sleeper
  std::atomic<int64_t> writes, opens, renames, syncs, threads;
  std::atomic<int64_t> allocations[kThreads];
  std::atomic<int64_t> wakes[kThreads];  // from a sleep until a stated time: of a device thread, its ticks
  static_assert(std::atomic<int64_t>::is_always_lock_free);
};

/// What the shim does and when, as LIMBERG_FAULT names it: "kind at more thread".
enum class Kind : int {
  none,
  write_error,     // the at-th write and `more` further ones: no space
  write_short,     // every write from the at-th on, for `more`: the half of it
  sync_error,      // bringing to the disk fails
  open_error,      // the at-th opening: too many files
  rename_error,    // the at-th renaming
  no_memory,       // the at-th allocation of `thread`, and `more` further ones of any thread
  no_thread,       // the at-th start of a thread, and `more` further ones
  slow_disk,       // every write takes `more` ms
  clock_stands,    // at the at-th reading: for `more` ms, then it is where it would have been
  clock_leaps,     // at the at-th reading: by `more` ms
  killed,          // at the at-th reading: SIGKILL
  crashed,         // the same: SIGSEGV
  aborted,         // the same: SIGABRT
  stopped,         // the same: SIGSTOP; whoever started it sends SIGCONT after `more` ms
  folder_removed,  // the same: the recording's folder, with all that is in it
  // Of a device, by whoever serves it (harness.cpp); `at` is in ms then:
  device_pulled,      // the line is taken away, and another laid after `more` ms
  packets_lost,       // one in `more`
  packets_doubled,    // the same
  packets_reordered,  // the same: one comes after its follower
  // Not faults of a machine but defects, planted to see that they are found:
  plant_hold,   // what is written to the recording stays in the process
  plant_hang,   // at the at-th reading: for ever
  plant_crash,  // at the at-th reading: SIGSEGV, though nobody asked for it
};

}  // namespace limberg::bench::faults
